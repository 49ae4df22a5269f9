# SPDX-License-Identifier: Apache-2.0
# ockham_library(ockham_<name> [sources...]) : a static library of one layer with the project's
# warnings; Ockham::<name> for who uses the project.
function(ockham_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wconversion -Wshadow
    -Wno-sign-conversion $<$<BOOL:${OCKHAM_WERROR}>:-Werror>)
endfunction()

function(ockham_library name)
  add_library(${name} STATIC ${ARGN})
  string(REGEX REPLACE "^ockham_" "" short ${name})
  add_library(Ockham::${short} ALIAS ${name})
  target_compile_features(${name} PUBLIC cxx_std_20) # what embeds us may be set to an older one
  target_include_directories(${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/shaders>)
  ockham_warnings(${name})
endfunction()
