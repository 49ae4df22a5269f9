# SPDX-License-Identifier: Apache-2.0
# ockham_add_test(<stem> [LIBRARIES targets...] [LABELS labels...] [SOURCES more.cpp...])
# Tests with the label gpu are registered again, see TestAgain.cmake.
# Builds <stem>_test.cpp of the present folder with GoogleTest and registers each of its tests.
# Tests of external data belong in <stem>_test.cpp of a folder that is added only when
# OCKHAM_DATA_DIR is set; the folder reaches them as a compile definition.
include(TestAgain)

function(ockham_add_test stem)
  cmake_parse_arguments(arg "" "" "LIBRARIES;LABELS;SOURCES" ${ARGN})
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR}/tests ${CMAKE_CURRENT_SOURCE_DIR})
  string(REPLACE "/" "_" target "test_${folder}_${stem}")
  add_executable(${target} ${stem}_test.cpp ${arg_SOURCES})
  target_link_libraries(${target} PRIVATE ${arg_LIBRARIES} GTest::gtest GTest::gtest_main)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
  ockham_warnings(${target})
  if(OCKHAM_DATA_DIR)
    target_compile_definitions(${target} PRIVATE OCKHAM_DATA_DIR="${OCKHAM_DATA_DIR}")
  endif()
  set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  ockham_discover_tests(${target} ${target}_tests "${arg_LABELS}" "")
  if("gpu" IN_LIST arg_LABELS AND NOT arg_LABELS MATCHES "nightly|stability")
    ockham_test_again(${target})
  endif()
endfunction()
