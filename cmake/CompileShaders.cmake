# SPDX-License-Identifier: Apache-2.0
# ockham_add_shaders(<target> [ROOT folder] FILES name... ) : compiles GLSL at build time and embeds
# it. A name is the path below ROOT (default: the project's shaders/), which is also the name that
# programs use: `surface/metrics.comp`. Variants follow a colon: `surface/gbuffer.frag:masked,textured`
# compiles with -DMASKED=1 -DTEXTURED=1 and is known under that whole name.
#
# Whoever links <target> has the shaders: no call needed. Includes are searched in ROOT, then in the
# project's shaders/; a change of an included file recompiles what includes it. Errors read
# `ERROR: file:line: text` and stop the build.
function(ockham_add_shaders target)
  cmake_parse_arguments(arg "" "ROOT" "FILES" ${ARGN})
  if(arg_UNPARSED_ARGUMENTS OR NOT arg_FILES)
    message(FATAL_ERROR "ockham_add_shaders(${target}): expected [ROOT folder] FILES name...")
  endif()
  find_program(OCKHAM_GLSLANG glslangValidator)
  if(NOT OCKHAM_GLSLANG)
    message(FATAL_ERROR "glslangValidator was not found: install the package glslang-tools")
  endif()
  get_property(shaders GLOBAL PROPERTY OCKHAM_SHADERS_DIR) # of the tree, or as installed
  if(NOT arg_ROOT)
    set(arg_ROOT ${shaders})
  endif()
  get_filename_component(root ${arg_ROOT} ABSOLUTE)
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/${target})
  file(MAKE_DIRECTORY ${folder})

  set(headers)
  set(includes "")
  set(rows "")
  foreach(name IN LISTS arg_FILES)
    string(REGEX MATCH "^([^:]+):?(.*)$" _ ${name})
    set(source ${root}/${CMAKE_MATCH_1})
    string(TOUPPER "${CMAKE_MATCH_2}" variant)
    string(REPLACE "," ";" variant "${variant}")
    list(TRANSFORM variant REPLACE "(.+)" "-D\\1=1")
    if(NOT EXISTS ${source})
      message(FATAL_ERROR "ockham_add_shaders(${target}): no shader ${source}")
    endif()
    string(MAKE_C_IDENTIFIER ${name} words)
    set(header ${folder}/${words}.h)
    add_custom_command(OUTPUT ${header}
      COMMAND ${OCKHAM_GLSLANG} --quiet -V --target-env vulkan1.3 -I${root} -I${shaders} ${variant}
        --depfile ${header}.d --vn ${words} -o ${header} ${source}
      DEPENDS ${source} DEPFILE ${header}.d
      COMMENT "Compiling shader ${name}" VERBATIM)
    list(APPEND headers ${header})
    string(APPEND includes "#include \"${words}.h\"\n")
    string(APPEND rows "    {\"${name}\", ${words}},\n")
  endforeach()

  # The anchor makes linkers take the table out of the static library although nobody calls it.
  file(CONFIGURE OUTPUT ${folder}/registry.cpp @ONLY CONTENT [[
// Made by ockham_add_shaders.
#include "framework/gpu/shader.hpp"

namespace {
using std::uint32_t;
@includes@
const ockham::gpu::EmbeddedShader table[] = {
@rows@};
const ockham::gpu::ShaderRegistration registration(table);
} // namespace

extern "C" {
extern const int ockham_shaders_@target@;
const int ockham_shaders_@target@ = 1;
}
]])
  add_library(${target} STATIC ${folder}/registry.cpp ${headers})
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_include_directories(${target} PRIVATE ${folder})
  target_link_libraries(${target} PUBLIC Ockham::gpu)
  target_link_options(${target} INTERFACE "LINKER:--undefined=ockham_shaders_${target}")
endfunction()
