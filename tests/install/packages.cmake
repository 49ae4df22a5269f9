# SPDX-License-Identifier: Apache-2.0
# cmake -DBUILD=folder -DWORK=folder -P packages.cmake : makes the Debian packages of a build and
# looks into them: what they depend on, and whether a program runs from where it is unpacked.
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})

function(run out)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE result
    OUTPUT_VARIABLE text ERROR_VARIABLE errors)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGN}: ${result}\n${text}${errors}")
  endif()
  set(${out} "${text}" PARENT_SCOPE)
endfunction()

function(expect package field words)
  file(GLOB file ${WORK}/${package}_*.deb)
  run(value dpkg-deb --field ${file} ${field})
  foreach(word IN LISTS words)
    if(NOT value MATCHES "(^|, )${word}(,| |$|\n)")
      message(SEND_ERROR "${package}: ${field} has no ${word}: ${value}")
    endif()
  endforeach()
endfunction()

run(ignored ${CMAKE_CPACK_COMMAND} --config ${BUILD}/CPackConfig.cmake -B ${WORK}
  -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip)
expect(ockham Depends "libc6;libvulkan1;libtinygltf2d;libopenexr-3-1-30")
expect(ockham Recommends "mesa-vulkan-drivers")
expect(libockham-dev Depends "libvulkan-dev;glslang-tools;libglm-dev;libopenexr-dev")

file(GLOB file ${WORK}/ockham_*.deb)
run(ignored dpkg-deb --extract ${file} ${WORK}/root)
run(text ${WORK}/root/usr/bin/hello_graph)
if(NOT text MATCHES "pi is about 3\\.14")
  message(SEND_ERROR "hello_graph of the package says: ${text}")
endif()
if(NOT EXISTS ${WORK}/root/usr/share/doc/ockham/copyright)
  message(SEND_ERROR "the package has no licence")
endif()
