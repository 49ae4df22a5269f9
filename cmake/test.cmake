# SPDX-License-Identifier: Apache-2.0
# cmake -P cmake/test.cmake : installs what is missing, unpacks a second driver, builds preset ci in
# build/ci and runs every test that is not labelled stability or nightly, those labelled figures first,
# with what they print. Fails if one fails.
#   cmake -DSETUP_ONLY=1 -P cmake/test.cmake    installs and stops
#   OCKHAM_DATA_DIR=folder                      also tests with external scenes and volumes
#   MESA_SHADER_CACHE_DIR=folder                compiled kernels [build/shader_cache]
include(${CMAKE_CURRENT_LIST_DIR}/setup.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/swiftshader.cmake)
if(SETUP_ONLY)
  return()
endif()

get_filename_component(data "$ENV{OCKHAM_DATA_DIR}" ABSOLUTE BASE_DIR ${CMAKE_CURRENT_BINARY_DIR})
if("$ENV{OCKHAM_DATA_DIR}" STREQUAL "")
  set(data "")
elseif(NOT IS_DIRECTORY ${data})
  message(FATAL_ERROR "OCKHAM_DATA_DIR: no folder '${data}'; unset it to test without external data")
endif()
set(ENV{OCKHAM_DATA_DIR} "${data}")

ockham_step(${CMAKE_COMMAND} --preset ci "-DOCKHAM_DATA_DIR=${data}")
ockham_step(${CMAKE_COMMAND} --build --preset ci --parallel ${cores})

# First what proves the graph, for its figures; ctest's own summary of the rest ends the output.
set(figures ${OCKHAM_ROOT}/build/ci/figures)
file(REMOVE_RECURSE ${figures})
file(MAKE_DIRECTORY ${figures})
set(ENV{OCKHAM_FIGURES} ${figures})
set(ctest ${CMAKE_CTEST_COMMAND} --test-dir build/ci --output-on-failure --no-tests=error
  --parallel ${cores})
ockham_step(${ctest} --label-regex "^figures$")
file(GLOB files ${figures}/*.txt)
foreach(file IN LISTS files)
  file(READ ${file} text)
  message(NOTICE "${text}")
endforeach()
ockham_step(${ctest} --label-exclude "^(stability|nightly|figures)$")
