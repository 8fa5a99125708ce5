# Runs a program that must end with exit code 1 and say why.
# Usage: cmake "-DCOMMAND=program;argument;..." "-DMESSAGE=regular expression" -P ...
execute_process(COMMAND ${COMMAND} RESULT_VARIABLE result OUTPUT_VARIABLE output
                ERROR_VARIABLE output)
if(NOT result EQUAL 1)
  message(FATAL_ERROR "ended with '${result}' instead of 1:\n${output}")
endif()
if(NOT output MATCHES "${MESSAGE}")
  message(FATAL_ERROR "does not say '${MESSAGE}':\n${output}")
endif()
