# SPDX-License-Identifier: Apache-2.0
# OCKHAM_SANITIZE="address;undefined" or "thread", for every target of the project.
if(OCKHAM_SANITIZE)
  string(REPLACE ";" "," _sanitizers "${OCKHAM_SANITIZE}")
  add_compile_options(-fsanitize=${_sanitizers} -fno-omit-frame-pointer -g
    -fno-sanitize-recover=undefined)
  add_link_options(-fsanitize=${_sanitizers})
endif()
