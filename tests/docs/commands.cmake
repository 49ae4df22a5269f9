# SPDX-License-Identifier: Apache-2.0
# cmake -DPAGE=file.md -DBIN=folder -DWORK=folder -P commands.cmake : runs each command of a page that
# begins with build/release/bin/, in the page's order, as a user with the files of `commands/` would.
file(REMOVE_RECURSE ${WORK})
file(COPY ${CMAKE_CURRENT_LIST_DIR}/commands/ DESTINATION ${WORK})
file(STRINGS ${PAGE} lines REGEX "^    build/release/bin/")
list(LENGTH lines count)
if(count EQUAL 0)
  message(FATAL_ERROR "${PAGE} has no command")
endif()
foreach(line IN LISTS lines)
  string(REGEX REPLACE "^    build/release/bin/" "${BIN}/" command "${line}")
  string(REGEX REPLACE " +#.*" "" command "${command}")
  separate_arguments(words UNIX_COMMAND "${command}")
  execute_process(COMMAND ${words} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE result
    OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT result EQUAL 0)
    message(SEND_ERROR "${line}\n${result}: ${text}")
  endif()
endforeach()
message(STATUS "${count} commands of ${PAGE}")
