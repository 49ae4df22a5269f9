# SPDX-License-Identifier: Apache-2.0
# What `cpack --config build/release/CPackConfig.cmake` packs, of the components of Install.cmake:
#   ockham_<version>_<architecture>.deb          sample programs
#   libockham-dev_<version>_<architecture>.deb   headers, static libraries, package files
# Programs depend on the shared libraries that dpkg-shlibdeps finds in them; the static libraries on
# what they were built with, for whoever links them links that too. Included by Install.cmake.
include(${CMAKE_CURRENT_LIST_DIR}/packages.cmake)
set(development_packages g++ glslang-tools pkg-config ${OCKHAM_LIBRARY_PACKAGES})
get_property(readers TARGET ockham_io_volume PROPERTY OCKHAM_READERS) # OCKHAM_WITH_ITK=1 ...
foreach(reader ITK OPENVDB NANOVDB)
  if("OCKHAM_WITH_${reader}=1" IN_LIST readers)
    list(APPEND development_packages ${OCKHAM_${reader}_PACKAGES})
  endif()
endforeach()
list(JOIN development_packages ", " development_packages)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR "Ockham")
set(CPACK_PACKAGE_CONTACT "Ockham's maintainers <maintainers@example.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL development)
if(OCKHAM_SAMPLES)
  list(APPEND CPACK_COMPONENTS_ALL samples)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_DEBUGINFO_PACKAGE OFF)

set(CPACK_DEBIAN_SAMPLES_PACKAGE_NAME ockham)
set(CPACK_DEBIAN_SAMPLES_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_SAMPLES_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_SAMPLES_PACKAGE_RECOMMENDS "mesa-vulkan-drivers, gnuplot-nox")
set(CPACK_COMPONENT_SAMPLES_DESCRIPTION
  "Programs that render scenes with adaptive anti-aliasing, and volumes with global illumination.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libockham-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "${development_packages}")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
  "Static libraries, headers and shaders: the render graph, its executor, scenes and passes.")

install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libockham-dev RENAME copyright
  COMPONENT development)
if(OCKHAM_SAMPLES)
  install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/ockham RENAME copyright
    COMPONENT samples)
endif()
include(CPack)
