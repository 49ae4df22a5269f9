# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` installs, by rule: every library that framework/ and passes/ define, as
# Ockham::<name without ockham_>, and every header there but those named below. What Config.cmake.in
# and ockham.pc.in require is read off the libraries' links. Included by the top CMakeLists.txt, last.
#   component development   headers, libraries, package files
#   component samples       the sample programs
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# Headers for sources of their own folder only; public headers must not include them.
set(internal_headers
  "framework/gpu/(selection|shader_compiler|workgroup_memory)"
  "framework/graph/(describe|compile/[a-z_]+|verify/[a-z_]+|explain/json_reader)"
  "framework/io/(dicom_check|gltf_[a-z]+|gzip|texture_image|volume_(payload|readers))"
  "framework/runtime/(barriers|bindings|commands_impl|frame|misuse|raster_target|recorder|resources)"
  "framework/runtime/submitter"
  "framework/scene/(atrium_parts|builtin_parts|builtin_textures|shapes)")

# Targets and what pkg-config calls them (or a flag), where that is not their package's name in CMake.
set(pc_names
  Threads::Threads -pthread
  TinyGLTF::TinyGLTF tinygltf
  Vulkan::Headers vulkan
  Vulkan::Vulkan vulkan
  ZLIB::ZLIB zlib
  glslang::SPIRV spirv
  glslang::glslang-default-resource-limits -lglslang-default-resource-limits)

# Packages that a package links and does not find itself.
set(before_glslang Threads)

# Targets of the given types that `folder` and folders below it define.
function(targets_below folder types out)
  set(targets)
  get_property(found DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target IN LISTS found)
    get_target_property(type ${target} TYPE)
    if(type IN_LIST types)
      list(APPEND targets ${target})
    endif()
  endforeach()
  get_property(subfolders DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
  foreach(subfolder IN LISTS subfolders)
    targets_below(${subfolder} "${types}" below)
    list(APPEND targets ${below})
  endforeach()
  set(${out} ${targets} PARENT_SCOPE)
endfunction()

# Appends to `list` what `target` links, each before what links it, then `target`. Targets of other
# packages (Package::name) and files are leaves.
function(append_link_closure target list)
  set(result ${${list}})
  if(target IN_LIST result)
    return()
  endif()
  if(TARGET ${target} AND NOT target MATCHES "::")
    get_target_property(links ${target} INTERFACE_LINK_LIBRARIES)
    string(REGEX REPLACE "\\$<BUILD_INTERFACE:[^>]*>" "" links "${links}")
    string(REGEX MATCHALL "[A-Za-z0-9_]+::[A-Za-z0-9_-]+|ockham_[a-z0-9_]+|/[^;>]+" links "${links}")
    foreach(link IN LISTS links)
      if(link MATCHES "^Ockham::")
        get_target_property(link ${link} ALIASED_TARGET)
      endif()
      append_link_closure(${link} result)
    endforeach()
  endif()
  list(APPEND result ${target})
  set(${list} ${result} PARENT_SCOPE)
endfunction()

# Libraries, their names for users, and for each the packages that it needs (in CMake's names, or
# PkgConfig:prefix:module).
set(libraries)
get_property(folders DIRECTORY PROPERTY SUBDIRECTORIES)
list(FILTER folders INCLUDE REGEX "^${PROJECT_SOURCE_DIR}/(framework/|passes$)")
foreach(folder IN LISTS folders)
  targets_below(${folder} "STATIC_LIBRARY;INTERFACE_LIBRARY" below)
  list(APPEND libraries ${below})
endforeach()
set(names)
set(needs "")
foreach(library IN LISTS libraries)
  string(REGEX REPLACE "^ockham_" "" name ${library})
  set_target_properties(${library} PROPERTIES EXPORT_NAME ${name})
  list(APPEND names ${name})
  set(packages)
  set(closure)
  append_link_closure(${library} closure)
  list(FILTER closure INCLUDE REGEX "::")
  foreach(target IN LISTS closure)
    string(REGEX REPLACE "::.*" "" package ${target})
    if(package STREQUAL "PkgConfig")
      string(REGEX REPLACE ".*::" "" prefix ${target})
      set(package PkgConfig:${prefix}:${${prefix}_MODULE_NAME})
    endif()
    list(APPEND packages ${before_${package}} ${package})
  endforeach()
  list(REMOVE_DUPLICATES packages)
  list(JOIN packages " " packages)
  string(APPEND needs "set(Ockham_${name}_NEEDS ${packages})\n")
endforeach()
list(JOIN names " " names)

install(TARGETS ${libraries} EXPORT Ockham
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ockham ${CMAKE_INSTALL_INCLUDEDIR}/ockham/shaders)
list(JOIN internal_headers "|" internal_headers)
install(DIRECTORY framework passes DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ockham
  COMPONENT development
  FILES_MATCHING PATTERN "*.hpp" REGEX "/(${internal_headers})\\.hpp$" EXCLUDE)
# What C++ and GLSL share, and what shaders include.
install(DIRECTORY shaders DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ockham
  COMPONENT development
  FILES_MATCHING PATTERN "*.h" PATTERN "*.glsl" PATTERN samples EXCLUDE)

# find_package(Ockham)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/Ockham)
set(shaders_folder ${CMAKE_INSTALL_INCLUDEDIR}/ockham/shaders)
configure_package_config_file(cmake/Config.cmake.in OckhamConfig.cmake
  INSTALL_DESTINATION ${package_folder} PATH_VARS shaders_folder
  NO_CHECK_REQUIRED_COMPONENTS_MACRO)
write_basic_package_version_file(OckhamConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/OckhamConfig.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/OckhamConfigVersion.cmake cmake/CompileShaders.cmake
  DESTINATION ${package_folder} COMPONENT development)
install(EXPORT Ockham NAMESPACE Ockham:: FILE OckhamTargets.cmake
  DESTINATION ${package_folder} COMPONENT development)

# pkg-config ockham: framework and passes. All libraries are static, so what they link is everybody's
# and nothing is private.
set(closure)
append_link_closure(ockham_framework closure)
append_link_closure(ockham_passes closure)
list(REVERSE closure) # what links comes before what is linked
set(pc_libraries "")
set(pc_requires)
foreach(target IN LISTS closure)
  if(target MATCHES "^PkgConfig::(.+)")
    list(APPEND pc_requires ${${CMAKE_MATCH_1}_MODULE_NAME})
  elseif(target MATCHES "^([^:]+)::")
    set(name ${CMAKE_MATCH_1})
    list(FIND pc_names ${target} index)
    if(NOT index EQUAL -1)
      math(EXPR index "${index} + 1")
      list(GET pc_names ${index} name)
    endif()
    if(name MATCHES "^-")
      string(APPEND pc_libraries " ${name}")
    else()
      list(APPEND pc_requires ${name})
    endif()
  elseif(target MATCHES "^/")
    string(APPEND pc_libraries " ${target}")
  else()
    get_target_property(type ${target} TYPE)
    get_target_property(options ${target} INTERFACE_LINK_OPTIONS)
    if(options)
      list(JOIN options " " options)
      string(REPLACE "LINKER:" "-Wl," options "${options}")
      string(APPEND pc_libraries " ${options}")
    endif()
    if(type STREQUAL "STATIC_LIBRARY")
      string(APPEND pc_libraries " -l${target}")
    endif()
  endif()
endforeach()
list(REMOVE_DUPLICATES pc_requires)
list(JOIN pc_requires " " pc_requires)
file(RELATIVE_PATH pc_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" pc_prefix ${pc_prefix})
configure_file(cmake/ockham.pc.in ockham.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/ockham.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)

if(OCKHAM_SAMPLES)
  targets_below(${PROJECT_SOURCE_DIR}/samples EXECUTABLE samples)
  install(TARGETS ${samples} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT samples)
endif()
include(Package)
