# SPDX-License-Identifier: GPL-3.0-only
# What building needs, and the words for what is missing.

# Ends the configuration; says how to install what is missing.
function(say_what_is_missing WHAT)
  set(purposes library)
  if(SPHERE_PROPAGATION_TESTS)
    list(APPEND purposes core)
  endif()
  if(SPHERE_PROPAGATION_PLUGINS)
    list(APPEND purposes plugin)
  endif()
  execute_process(COMMAND ${PROJECT_SOURCE_DIR}/scripts/needs packages ${purposes} OUTPUT_VARIABLE advice ERROR_VARIABLE advice)
  message(FATAL_ERROR "${WHAT} was not found.\n${advice}")
endfunction()

# find_package(NAME ...), required.
macro(need_package NAME)
  find_package(${NAME} ${ARGN} QUIET)
  if(NOT ${NAME}_FOUND)
    say_what_is_missing(${NAME})
  endif()
endmacro()
