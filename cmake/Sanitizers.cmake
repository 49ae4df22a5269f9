# SPDX-License-Identifier: Apache-2.0
# OCKHAM_SANITIZE="address;undefined" or "thread", for every target of the project.
if(OCKHAM_SANITIZE)
  string(REPLACE ";" "," _sanitizers "${OCKHAM_SANITIZE}")
  # -O1 and line numbers alone: cheaper to build, and reports keep every frame's name and line.
  add_compile_options(-fsanitize=${_sanitizers} -fno-omit-frame-pointer -O1 -g1
    -fno-sanitize-recover=undefined)
  add_link_options(-fsanitize=${_sanitizers})
endif()
# ockham_sanitized(<target>) : for a program that uses the driver or OpenVDB, or a library whose users
# do: tells the sanitizer what of its findings is theirs.
function(ockham_sanitized target)
  if(NOT OCKHAM_SANITIZE)
    return()
  endif()
  get_target_property(type ${target} TYPE)
  set(scope PRIVATE)
  if(type STREQUAL "STATIC_LIBRARY") # whose objects come along only where they are called
    set(scope INTERFACE)
  endif()
  target_sources(${target} ${scope} ${PROJECT_SOURCE_DIR}/tests/support/sanitized.cpp)
  target_link_libraries(${target} ${scope} ${CMAKE_DL_LIBS})
endfunction()

if(OCKHAM_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang" OR CMAKE_CXX_COMPILER_VERSION VERSION_LESS 16)
    message(FATAL_ERROR "OCKHAM_FUZZ needs clang 16 or later, which has libFuzzer and C++20: install "
      "clang-16 and libclang-rt-16-dev, then cmake --preset fuzz")
  endif()
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()
