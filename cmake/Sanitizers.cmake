# SPDX-License-Identifier: Apache-2.0
# OCKHAM_SANITIZE="address;undefined" or "thread", for every target of the project.
if(OCKHAM_SANITIZE)
  string(REPLACE ";" "," _sanitizers "${OCKHAM_SANITIZE}")
  add_compile_options(-fsanitize=${_sanitizers} -fno-omit-frame-pointer -g
    -fno-sanitize-recover=undefined)
  add_link_options(-fsanitize=${_sanitizers})
endif()
if(OCKHAM_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang" OR CMAKE_CXX_COMPILER_VERSION VERSION_LESS 16)
    message(FATAL_ERROR "OCKHAM_FUZZ needs clang 16 or later, which has libFuzzer and C++20: install "
      "clang-16 and libclang-rt-16-dev, then cmake --preset fuzz")
  endif()
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()
