# SPDX-License-Identifier: Apache-2.0
# Set-up shared by test.cmake and demo.cmake, which include it in script mode: packages, number of
# cores, the driver's shader cache. Never part of configuring the project.
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/packages.cmake)
include(ProcessorCount)

get_filename_component(OCKHAM_ROOT ${CMAKE_CURRENT_LIST_DIR}/.. ABSOLUTE)
ProcessorCount(cores)
if(cores EQUAL 0)
  set(cores 1)
endif()

# Installs what is missing of OCKHAM_PACKAGES as root; otherwise stops with the line that does.
function(ockham_install_packages)
  find_program(dpkg_query dpkg-query)
  if(NOT dpkg_query)
    list(JOIN OCKHAM_PACKAGES " " packages)
    message(NOTICE "Not a Debian system, so nothing is installed. What Debian 12 would need:\n"
      "  ${packages}")
    return()
  endif()
  set(missing)
  foreach(package IN LISTS OCKHAM_PACKAGES)
    execute_process(COMMAND ${dpkg_query} --show "--showformat=\${db:Status-Status}" ${package}
      OUTPUT_VARIABLE status ERROR_QUIET)
    if(NOT status STREQUAL "installed")
      list(APPEND missing ${package})
    endif()
  endforeach()
  if(NOT missing)
    return()
  endif()

  list(JOIN missing " " packages)
  execute_process(COMMAND id -u OUTPUT_VARIABLE user OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT user EQUAL 0)
    message(NOTICE "Missing packages; install them and try again:\n"
      "  sudo apt-get update && sudo apt-get install -y --no-install-recommends ${packages}")
    message(FATAL_ERROR "packages are missing and only root can install them")
  endif()
  message(NOTICE "Installing ${packages}")
  # A failed update need not matter: the lists at hand may do.
  execute_process(COMMAND apt-get -q update)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env DEBIAN_FRONTEND=noninteractive
    apt-get -q install -y --no-install-recommends ${missing} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "apt-get could not install: ${packages}")
  endif()
endfunction()

# Runs a step in the repository's root; stops if it fails.
function(ockham_step)
  execute_process(COMMAND ${ARGV} WORKING_DIRECTORY ${OCKHAM_ROOT} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "failed (${result}): ${command}")
  endif()
endfunction()

ockham_install_packages()

# lavapipe compiles each kernel to machine code when it is first used; this keeps the result.
if(NOT DEFINED ENV{MESA_SHADER_CACHE_DIR})
  set(ENV{MESA_SHADER_CACHE_DIR} ${OCKHAM_ROOT}/build/shader_cache)
endif()
file(MAKE_DIRECTORY $ENV{MESA_SHADER_CACHE_DIR})
