# SPDX-License-Identifier: Apache-2.0
# CheckLayers.cmake must report every line of tree/ that is marked `// wrong`, and no other.
set(checker ${CMAKE_CURRENT_LIST_DIR}/../../cmake/CheckLayers.cmake)
set(tree ${CMAKE_CURRENT_LIST_DIR}/tree)

execute_process(COMMAND ${CMAKE_COMMAND} -DROOT=${tree} -P ${checker}
  RESULT_VARIABLE result ERROR_VARIABLE text OUTPUT_QUIET)
if(result EQUAL 0)
  message(FATAL_ERROR "violations were found, yet the check passed")
endif()
string(REGEX MATCHALL "[a-z_/]+\\.[hc]pp:[0-9]+: " found "${text}")
list(TRANSFORM found REPLACE ": $" "")

execute_process(COMMAND grep -rnoE "// wrong" framework passes samples WORKING_DIRECTORY ${tree}
  OUTPUT_VARIABLE text OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
string(REPLACE ":// wrong" "" text "${text}")
string(REPLACE "\n" ";" expected "${text}")

list(SORT found)
list(SORT expected)
if(NOT found STREQUAL expected)
  set(unexpected ${found})
  list(REMOVE_ITEM unexpected ${expected})
  list(REMOVE_ITEM expected ${found})
  message(FATAL_ERROR "not reported: ${expected}\nreported without reason or twice: ${unexpected}")
endif()

execute_process(COMMAND ${CMAKE_COMMAND} -DROOT=${tree}/framework -P ${checker}
  RESULT_VARIABLE result ERROR_QUIET OUTPUT_QUIET)
if(result EQUAL 0)
  message(FATAL_ERROR "a folder without sources passed the check")
endif()
list(LENGTH found count)
message(STATUS "all ${count} violations are reported")
