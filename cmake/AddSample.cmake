# SPDX-License-Identifier: Apache-2.0
# ockham_add_sample(folder) : the program samples/<folder>/main.cpp, named by the folder's last part.
function(ockham_add_sample folder)
  get_filename_component(name ${folder} NAME)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp)
  add_executable(${name} ${sources})
  target_link_libraries(${name} PRIVATE ockham_app ockham_passes)
  ockham_warnings(${name})
  ockham_sanitized(${name})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
endfunction()
