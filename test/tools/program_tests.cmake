# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

find_package(CLI11 2.1 REQUIRED)

# Its options of an encoder, without the program.
pcl_ext_add_test(
  test_options
  SOURCES
    tools/test_setting_options.cpp
    ${PROJECT_SOURCE_DIR}/tools/pcl_ext/options/help_format.cpp
    ${PROJECT_SOURCE_DIR}/tools/pcl_ext/options/setting_options.cpp
    ${PROJECT_SOURCE_DIR}/tools/pcl_ext/options/text_values.cpp
  LIBRARIES pcl_ext_measuring CLI11::CLI11)
target_include_directories(test_options PRIVATE ${PROJECT_SOURCE_DIR}/tools/pcl_ext)

# The program pcl_ext, run as a user runs it.
find_package(nlohmann_json 3 REQUIRED)
pcl_ext_add_test(
  test_program
  SOURCES
    tools/cloud_bags.cpp
    tools/program.cpp
    tools/test_advice.cpp
    tools/test_program_advise.cpp
    tools/test_program_bags.cpp
    tools/test_program_benchmark.cpp
    tools/test_program_encode.cpp
    tools/test_program_decode.cpp
    tools/test_program_files.cpp
    tools/test_program_far_clouds.cpp
    tools/test_program_fields.cpp
    tools/test_program_foreign_bags.cpp
    tools/test_program_help.cpp
    tools/test_program_hostile_inputs.cpp
    tools/test_program_inputs.cpp
    tools/test_program_interruption.cpp
    tools/test_program_kept.cpp
    tools/test_program_layouts.cpp
    tools/test_program_jobs.cpp
    tools/test_program_limits.cpp
    tools/test_program_many_bags.cpp
    tools/test_program_live.cpp
    tools/test_program_options.cpp
    tools/test_program_parts.cpp
    tools/test_program_recordings.cpp
    tools/test_program_ros1_bags.cpp
    tools/test_program_sentences.cpp
    ${PROJECT_SOURCE_DIR}/clouds/file_stamps.cpp
    ${PROJECT_SOURCE_DIR}/clouds/file_text.cpp
    ${PROJECT_SOURCE_DIR}/tools/pcl_ext/advice/setting_choice.cpp
    ${PROJECT_SOURCE_DIR}/tools/pcl_ext/advice/surface_closure.cpp
  LIBRARIES pcl_ext_recording_objects ${PCL_EXT_PCL_IO} nlohmann_json::nlohmann_json)
target_compile_definitions(test_program
                           PRIVATE PCL_EXT_PROGRAM="$<TARGET_FILE:pcl_ext_program>")
target_include_directories(test_program PRIVATE ${PROJECT_SOURCE_DIR}/tools/pcl_ext)
target_include_directories(test_program SYSTEM PRIVATE ${PCL_EXT_LZ4_HEADERS})
add_dependencies(test_program pcl_ext_program)
if(PCL_EXT_WITH_SQLITE)
  target_compile_definitions(test_program PRIVATE PCL_EXT_HAS_SQLITE)
  target_include_directories(test_program SYSTEM PRIVATE ${SQLite3_INCLUDE_DIRS}
                                                         ${PCL_EXT_ZSTD_HEADERS})
endif()
if(TARGET pcl_ext_view)
  target_sources(test_program PRIVATE tools/test_program_view.cpp
                                      view/clients.cpp)
endif()
if(TARGET pcl_ext_link)
  target_sources(test_program PRIVATE tools/test_program_centres.cpp
                                      tools/test_program_losses.cpp
                                      tools/test_program_receive.cpp
                                      tools/test_program_replay.cpp
                                      tools/test_program_map.cpp
                                      tools/test_program_send.cpp
                                      tools/test_program_site_state.cpp)
  target_link_libraries(test_program PRIVATE pcl_ext_link_objects ${PCL_EXT_NATS_LIBRARY})
  target_compile_definitions(
    test_program PRIVATE PCL_EXT_SITE_EXAMPLES="${PROJECT_SOURCE_DIR}/tools/site"
                         PCL_EXT_NATS_SERVER_FOLDER="${nats_server_folder}")
endif()

# What Prometheus is told, and the documents about it.
if(TARGET pcl_ext_view AND TARGET pcl_ext_link)
  add_executable(write_health_metrics nodes/write_health_metrics.cpp)
  target_include_directories(write_health_metrics PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(write_health_metrics PRIVATE pcl_ext pcl_ext_link pcl_ext_warnings)
  add_test(NAME metrics
           COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/tools/test_metrics.py
                   $<TARGET_FILE:pcl_ext_program> $<TARGET_FILE:write_health_metrics>)
endif()

# The documents about a site, as somebody follows them.
if(TARGET pcl_ext_view AND TARGET pcl_ext_link)
  add_test(NAME site_documents
           COMMAND ${Python3_EXECUTABLE} -B
                   ${CMAKE_CURRENT_SOURCE_DIR}/tools/test_site_documents.py
                   $<TARGET_FILE:pcl_ext_program>)
  set_tests_properties(site_documents PROPERTIES LABELS unsanitized)
endif()

add_test(NAME scripts COMMAND ${Python3_EXECUTABLE} -B -m unittest test_scripts
         WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/tools)

# The script prints the help before it installs or builds anything, which takes longer.
pcl_ext_add_program_test(run_script_help 0 "Usage: .*encode" sh
                         ${PROJECT_SOURCE_DIR}/tools/run.sh --help)
pcl_ext_add_program_test(run_script_missing_file 1 "There is no 'no_such_file.pcd'" sh
                         ${PROJECT_SOURCE_DIR}/tools/run.sh encode no_such_file.pcd -o x)
pcl_ext_add_program_test(run_script_missing_command 2 "There is no command 'encore'" sh
                         ${PROJECT_SOURCE_DIR}/tools/run.sh encore x.pcd)
set_tests_properties(run_script_help run_script_missing_file run_script_missing_command
                     PROPERTIES TIMEOUT 10)
