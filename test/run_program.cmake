# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Runs a program that must end with an exit status and print something.
# Usage: cmake "-DCOMMAND=program;argument;..." -DSTATUS=number "-DOUTPUT=regular expression"
#   -P run_program.cmake
execute_process(COMMAND ${COMMAND} RESULT_VARIABLE result OUTPUT_VARIABLE output
                ERROR_VARIABLE output)
if(NOT result STREQUAL STATUS)
  message(FATAL_ERROR "ended with '${result}' instead of ${STATUS}:\n${output}")
endif()
if(NOT output MATCHES "${OUTPUT}")
  message(FATAL_ERROR "does not say '${OUTPUT}':\n${output}")
endif()
