# SPDX-License-Identifier: Apache-2.0
# A second Vulkan driver for the tests: SwiftShader, out of Debian's package chromium-common.
# test.cmake includes this after setup.cmake. The package is downloaded, not installed, and two files
# of it are kept in build/swiftshader, where TestAgain.cmake finds them. Nothing is done where they
# are already; root is not needed.

# Puts the driver into `folder`. Leaves in `reason` what prevented it; empty for success.
function(ockham_fetch_swiftshader folder)
  set(reason "" PARENT_SCOPE)
  if(EXISTS ${folder}/vk_swiftshader_icd.json)
    return()
  endif()
  find_program(apt_get apt-get)
  find_program(dpkg_deb dpkg-deb)
  find_program(tar tar)
  if(NOT apt_get OR NOT dpkg_deb OR NOT tar)
    set(reason "apt-get, dpkg-deb or tar was not found" PARENT_SCOPE)
    return()
  endif()

  set(part ${folder}.part) # renamed when complete
  file(REMOVE_RECURSE ${part})
  file(MAKE_DIRECTORY ${part})
  set(download ${apt_get} -q download chromium-common)
  execute_process(COMMAND ${download} WORKING_DIRECTORY ${part} RESULT_VARIABLE result
    OUTPUT_QUIET ERROR_QUIET)
  if(NOT result EQUAL 0)
    # The lists at hand are missing, or name a version that an update has replaced.
    execute_process(COMMAND ${apt_get} -q update OUTPUT_QUIET ERROR_QUIET)
    execute_process(COMMAND ${download} WORKING_DIRECTORY ${part} RESULT_VARIABLE result
      OUTPUT_QUIET ERROR_QUIET)
  endif()
  if(NOT result EQUAL 0)
    file(REMOVE_RECURSE ${part})
    set(reason "'apt-get download chromium-common' failed; 'apt-get update', as root, may help"
      PARENT_SCOPE)
    return()
  endif()

  file(GLOB package ${part}/*.deb)
  execute_process(COMMAND ${dpkg_deb} --fsys-tarfile ${package}
    COMMAND ${tar} -x --strip-components=4 ./usr/lib/chromium/libvk_swiftshader.so
      ./usr/lib/chromium/vk_swiftshader_icd.json
    WORKING_DIRECTORY ${part} RESULTS_VARIABLE results ERROR_QUIET)
  if(NOT results STREQUAL "0;0")
    file(REMOVE_RECURSE ${part})
    set(reason "chromium-common has no libvk_swiftshader.so and vk_swiftshader_icd.json"
      PARENT_SCOPE)
    return()
  endif()
  file(REMOVE ${package})
  file(REMOVE_RECURSE ${folder})
  file(RENAME ${part} ${folder})
endfunction()

ockham_fetch_swiftshader(${OCKHAM_ROOT}/build/swiftshader)
if(reason)
  set(text "No second driver: ${reason}. Tests labelled swiftshader are not registered.")
  find_program(dpkg_query dpkg-query)
  if(dpkg_query AND NOT "$ENV{CI}" STREQUAL "")
    message(FATAL_ERROR "${text} CI on Debian must run them.")
  endif()
  message(NOTICE "${text}")
endif()
