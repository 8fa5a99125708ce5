# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# A test that runs a program, and passes if that ends with an exit status and prints
# something. The property PASS_REGULAR_EXPRESSION would ignore the exit status.
#   name     of the test
#   status   the exit status
#   output   regular expression that standard output and errors match
#   ARGN     the program and its arguments, without semicolons
set(PCL_EXT_RUN_PROGRAM ${CMAKE_CURRENT_LIST_DIR}/run_program.cmake)
function(pcl_ext_add_program_test name status output)
  add_test(NAME ${name}
           COMMAND ${CMAKE_COMMAND} "-DCOMMAND=${ARGN}" -DSTATUS=${status}
                   "-DOUTPUT=${output}" -P ${PCL_EXT_RUN_PROGRAM})
endfunction()
