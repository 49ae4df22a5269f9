# SPDX-License-Identifier: Apache-2.0
# cmake -DBUILD=folder -DCONFIG=name -DCOMPONENT=name -DPREFIX=folder -P install.cmake : installs a
# component of a build into a folder that has nothing else, so that nothing of an earlier one helps.
file(REMOVE_RECURSE ${PREFIX})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --config ${CONFIG}
    --component ${COMPONENT} --prefix ${PREFIX}
  RESULT_VARIABLE result OUTPUT_QUIET)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "cmake --install failed: ${result}")
endif()
