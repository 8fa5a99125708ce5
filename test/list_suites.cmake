# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Writes a file for ctest with one test for each test suite of a program, with all of its
# instantiations: cmake -DPROGRAM=... -DOUTPUT=...
# [-DLABEL=...] -P list_suites.cmake
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE lines
                RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} --gtest_list_tests ended with ${result}")
endif()
string(REGEX MATCHALL "(^|\n)[^ \n]+\\." suites "${lines}")
# Prefix/Suite. and Suite/0. are both of Suite.
list(TRANSFORM suites REPLACE "\n|\\.$" "")
list(TRANSFORM suites REPLACE "/[0-9]+$" "")
list(TRANSFORM suites REPLACE "^.*/" "")
list(REMOVE_DUPLICATES suites)
set(tests "")
foreach(suite ${suites})
  string(APPEND tests
         "add_test(${suite} \"${PROGRAM}\" "
         "--gtest_filter=${suite}.*:${suite}/*:*/${suite}.*:*/${suite}/*)\n"
         "set_tests_properties(${suite} PROPERTIES TIMEOUT 600 LABELS \"${LABEL}\")\n")
endforeach()
file(WRITE ${OUTPUT} "${tests}")
