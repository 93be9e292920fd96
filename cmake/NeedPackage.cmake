# SPDX-License-Identifier: GPL-3.0-only
# What building needs, and the words for what is missing.

# Ends the configuration; says how to install what is missing.
function(say_what_is_missing WHAT)
  execute_process(COMMAND ${CMAKE_SOURCE_DIR}/scripts/needs packages OUTPUT_VARIABLE advice ERROR_VARIABLE advice)
  message(FATAL_ERROR "${WHAT} was not found.\n${advice}")
endfunction()

# find_package(NAME ...), required.
macro(need_package NAME)
  find_package(${NAME} ${ARGN} QUIET)
  if(NOT ${NAME}_FOUND)
    say_what_is_missing(${NAME})
  endif()
endmacro()
