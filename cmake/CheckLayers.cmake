# SPDX-License-Identifier: Apache-2.0
# cmake [-DROOT=folder] -P cmake/CheckLayers.cmake : checks who includes what below ROOT (default:
# this repository), and who calls Vulkan. Prints "file:line: what was found: the rule it breaks" for
# every violation and fails if there is one. Run as the test `layers`.
cmake_minimum_required(VERSION 3.25)
if(NOT ROOT)
  get_filename_component(ROOT ${CMAKE_CURRENT_LIST_DIR}/.. ABSOLUTE)
endif()

# What each layer may include besides itself: the arrows of the tree.
set(framework core graph gpu runtime scene scene_gpu io image_error app)
set(layers ${framework} passes passes/pipelines samples)
set(uses_core "")
set(uses_graph core)
set(uses_gpu core)
set(uses_runtime core graph gpu)
set(uses_scene core shaders)
set(uses_scene_gpu core graph gpu runtime scene shaders)
set(uses_io core scene)
set(uses_image_error core)
set(uses_app ${framework})
set(uses_passes core graph runtime scene scene_gpu shaders)
set(uses_passes/pipelines ${uses_passes} gpu passes)
set(uses_samples ${framework} passes passes/pipelines shaders)

# The headers of passes that other passes may include: the types on the edges between them.
set(edge_types
  passes/shader_variant.hpp
  passes/schedule/buckets.hpp
  passes/schedule/tile_list.hpp
  passes/surface/allocate.hpp
  passes/surface/clusters.hpp
  passes/surface/draw_scene.hpp
  passes/surface/sample_order.hpp
  passes/surface/frame.hpp
  passes/surface/gbuffer.hpp
  passes/surface/shading_inputs.hpp
  passes/volume/frame.hpp
  passes/volume/medium_inputs.hpp)

# Third-party headers: pattern of the header, pattern of the files that may include it, in words.
set(third_party
  "^vulkan/" "^framework/(graph|gpu|runtime)/" "only graph, gpu and runtime see Vulkan"
  "^spirv" "^framework/gpu/[^/]*\\.cpp$" "only sources of framework/gpu read SPIR-V"
  "^glslang/" "^framework/gpu/shader_compiler\\.cpp$" "only framework/gpu/shader_compiler.cpp compiles GLSL"
  "^tiny_?gltf" "^framework/io/gltf[^/]*\\.cpp$" "only framework/io/gltf*.cpp read glTF"
  "^(OpenEXR|Imath)/|^Imf" "^framework/io/exr\\.cpp$" "only framework/io/exr.cpp reads EXR"
  "^(stb/)?stb_" "^framework/io/[^/]*\\.cpp$" "only sources of framework/io code pictures"
  "^itk[A-Z]" "^framework/io/volume_itk\\.cpp$" "only framework/io/volume_itk.cpp sees ITK"
  "^openvdb/" "^framework/io/volume_openvdb\\.cpp$" "only framework/io/volume_openvdb.cpp reads VDB"
  "^nanovdb/" "^framework/io/volume_nanovdb\\.cpp$" "only framework/io/volume_nanovdb.cpp reads NanoVDB"
  "^zlib" "^framework/io/gzip\\.cpp$" "only framework/io/gzip.cpp inflates"
  "^CLI/" "^(framework/app|samples)/.*\\.cpp$" "only sources of framework/app and samples parse flags"
  "^opencv" "^samples/metrics/network_metric\\.cpp$" "only samples/metrics/network_metric.cpp runs networks"
  "^GLFW" "^samples/viewer/(window|presenter|swapchain)\\.cpp$" "only the viewer's window, presenter and swapchain see GLFW"
  "^(backends/)?imgui" "^samples/viewer/.*\\.cpp$" "only sources of samples/viewer draw widgets")

set(violations 0)
macro(violation text)
  message(NOTICE "${file}:${line}: ${text}")
  math(EXPR violations "${violations} + 1")
endmacro()

# The layer of a path below the root, empty for what is none: framework/core/rng.hpp is of `core`.
function(layer_of path out)
  if(path MATCHES "^framework/([^/]+)/")
    set(${out} ${CMAKE_MATCH_1} PARENT_SCOPE)
  elseif(path MATCHES "^(passes/pipelines)/|^(passes|samples|shaders|tests)/")
    set(${out} ${CMAKE_MATCH_1}${CMAKE_MATCH_2} PARENT_SCOPE)
  else()
    set(${out} "" PARENT_SCOPE)
  endif()
endfunction()

# Lines "file:line:match" of all C++ files of the checked folders.
function(grep pattern out)
  execute_process(COMMAND grep -rnoE --include=*.cpp --include=*.hpp --include=*.h ${pattern}
      framework passes samples
    WORKING_DIRECTORY ${ROOT} OUTPUT_VARIABLE text RESULT_VARIABLE result
    OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(result GREATER 1)
    message(FATAL_ERROR "grep failed in '${ROOT}'")
  endif()
  string(REGEX REPLACE "[][;\\]" " " text "${text}") # what would end or join items of a list
  string(REPLACE "\n" ";" text "${text}")
  set(${out} "${text}" PARENT_SCOPE)
endfunction()

grep("^[ \t]*#[ \t]*include[ \t]*[\"<][^\">]+" includes)
list(LENGTH includes include_count)
foreach(item IN LISTS includes)
  string(REGEX MATCH "^([^:]+):([0-9]+):.*([\"<])([^\"<]+)$" _ "${item}")
  set(file ${CMAKE_MATCH_1})
  set(line ${CMAKE_MATCH_2})
  set(quote ${CMAKE_MATCH_3})
  set(header ${CMAKE_MATCH_4})
  layer_of(${file} from)
  layer_of(${header} to)

  if(NOT from IN_LIST layers)
    violation("layer '${from}' is unknown to CheckLayers.cmake")
  elseif(to STREQUAL "")
    set(is_third_party FALSE)
    set(rules ${third_party})
    while(rules)
      list(POP_FRONT rules pattern files rule)
      if(header MATCHES "${pattern}")
        set(is_third_party TRUE)
        if(NOT file MATCHES "${files}")
          violation("<${header}>: ${rule}")
        endif()
      endif()
    endwhile()
    if(NOT is_third_party AND quote STREQUAL "\"")
      violation("\"${header}\": quoted includes name a path from the repository's root")
    endif()
  elseif(quote STREQUAL "<")
    violation("<${header}>: the project's own headers are quoted")
  elseif(NOT to STREQUAL from AND NOT to IN_LIST uses_${from})
    list(JOIN uses_${from} " " allowed)
    violation("\"${header}\": '${from}' may include only: ${from} ${allowed}")
  elseif(from STREQUAL "passes" AND to STREQUAL "passes" AND NOT header IN_LIST edge_types)
    string(REGEX REPLACE "\\.[a-z]+$" "" file_stem ${file})
    string(REGEX REPLACE "\\.[a-z]+$" "" header_stem ${header})
    if(NOT file_stem STREQUAL header_stem)
      violation("\"${header}\": a pass includes of other passes only edge types (edge_types in CheckLayers.cmake)")
    endif()
  endif()
endforeach()

# Outside of comments; PFN_vk... and VK_... are types and constants.
grep("^([^/]|/[^/])*\\<vk[A-Z][A-Za-z0-9]*" calls)
foreach(item IN LISTS calls)
  string(REGEX MATCH "^([^:]+):([0-9]+):.*(vk[A-Z][A-Za-z0-9]*)$" _ "${item}")
  set(file ${CMAKE_MATCH_1})
  set(line ${CMAKE_MATCH_2})
  set(call ${CMAKE_MATCH_3})
  if(NOT file MATCHES "^framework/(gpu|runtime)/|^samples/viewer/(presenter|swapchain)\\.cpp$")
    violation("${call}: Vulkan is called only in framework/gpu, framework/runtime and the viewer's presenter and swapchain")
  endif()
endforeach()

if(violations)
  message(FATAL_ERROR "${violations} violations of the layers")
elseif(include_count EQUAL 0)
  message(FATAL_ERROR "no includes found below '${ROOT}'")
endif()
message(STATUS "${include_count} includes keep to the layers")
