# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Installs the library into an empty prefix, moves the prefix, and there builds and runs
# projects with find_package(pcl_ext), and programs with pkg-config.
# Usage: cmake -DSOURCE_DIR=... -DWORK_DIR=... -DLIBDIR=... -DGENERATOR=...
#   -DCXX_COMPILER=... -DCXX_FLAGS=... [-DBUILD_DIR=... | -DAS_SUBDIRECTORY=ON |
#   -DCODEC_ALONE=ON] -P install_and_use.cmake
#   BUILD_DIR        an existing build tree; the examples are built and run, too
#   NEW_BUILD_DIR    where another one is made, else in WORK_DIR. Beside those of the
#                    same options a compiler cache has its files
#   AS_SUBDIRECTORY  static libraries, built by a project that adds this one as a
#                    subdirectory
#   CODEC_ALONE      without pcl_ext::pcl_ext, as on a machine that has no PCL

set(build_type Release)
if(AS_SUBDIRECTORY)
  # All is compiled for this test alone, which takes twice the time with optimization.
  set(build_type None)
endif()
set(toolchain -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${CXX_COMPILER}
              -DCMAKE_CXX_FLAGS=${CXX_FLAGS} -DCMAKE_BUILD_TYPE=${build_type})
# Each file by itself would take twice the time.
set(unity -DPCL_EXT_UNITY_BUILD=ON)
set(without_pcl -DCMAKE_DISABLE_FIND_PACKAGE_PCL=ON)
set(packages ${SOURCE_DIR}/test/package)
set(prefix ${WORK_DIR}/moved)

function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${WORK_DIR} RESULT_VARIABLE result OUTPUT_VARIABLE output
                  ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGN}\nended with ${result}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

# Builds a project with what was installed.
function(build_project source name)
  run(${CMAKE_COMMAND} -S ${source} -B ${WORK_DIR}/${name} ${toolchain}
      -DCMAKE_PREFIX_PATH=${prefix} ${ARGN})
  run(${CMAKE_COMMAND} --build ${WORK_DIR}/${name})
endfunction()

function(run_program name)
  run(${WORK_DIR}/${name})
  message(STATUS "${output}")
endfunction()

# Compiles a program without CMake, with what pkg-config says of a module.
function(compile_with_pkg_config module program)
  run(${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${prefix}/${LIBDIR}/pkgconfig
      pkg-config --cflags --libs ${module})
  string(STRIP "${output}" flags)
  separate_arguments(flags UNIX_COMMAND "${CXX_FLAGS} ${flags}")
  run(${CXX_COMPILER} -std=c++17 ${packages}/${program}/${program}.cpp ${flags}
      -Wl,-rpath,${prefix}/${LIBDIR} -o ${WORK_DIR}/${program}_by_pkg_config)
  run_program(${program}_by_pkg_config)
endfunction()

function(expect_without text what)
  foreach(word ${ARGN})
    string(FIND "${text}" "${word}" position)
    if(NOT position EQUAL -1)
      message(FATAL_ERROR "${what} mentions '${word}':\n${text}")
    endif()
  endforeach()
endfunction()

# Expects that find_package(pcl_ext) with these arguments ends with a status and prints a
# text.
function(expect_find arguments status text)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -S ${packages}/find -B ${WORK_DIR}/find ${toolchain}
            -DCMAKE_PREFIX_PATH=${prefix} -DARGUMENTS=${arguments} ${ARGN}
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " line "${output}")
  string(FIND "${line}" "${text}" position)
  if(NOT result EQUAL status OR position EQUAL -1)
    message(FATAL_ERROR "find_package with '${arguments}' ended with ${result}, "
                        "expected ${status} and '${text}':\n${output}")
  endif()
endfunction()

# Writes the block of code of a document that begins with a text.
function(write_block document first_text file)
  file(READ ${SOURCE_DIR}/${document} text)
  string(REGEX MATCH "```[a-z]+\n(${first_text}[^`]*)```" block "${text}")
  file(WRITE ${WORK_DIR}/readme_source/${file} "${CMAKE_MATCH_1}")
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR})
if(NOT BUILD_DIR)
  set(BUILD_DIR ${WORK_DIR}/build)
  if(NEW_BUILD_DIR)
    set(BUILD_DIR ${NEW_BUILD_DIR})
    file(REMOVE_RECURSE ${BUILD_DIR})
  endif()
  set(configure ${CMAKE_COMMAND} -B ${BUILD_DIR} ${toolchain} ${unity}
                -DCMAKE_INSTALL_LIBDIR=${LIBDIR}
                -DPCL_EXT_WARNINGS_AS_ERRORS=${WARNINGS_AS_ERRORS})
  if(AS_SUBDIRECTORY)
    list(APPEND configure -S ${packages}/subdirectory -DPCL_EXT_SOURCE_DIR=${SOURCE_DIR})
    # Without options the parent project gets no rule of installation and no test.
    run(${configure})
    run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/installed)
    file(GLOB_RECURSE unwanted ${WORK_DIR}/installed/* ${BUILD_DIR}/CTestTestfile.cmake)
    if(unwanted)
      message(FATAL_ERROR "the parent project got ${unwanted}")
    endif()
    run(${configure} -DPCL_EXT_INSTALL=ON -DPCL_EXT_BUILD_SIMULATOR=ON)
  elseif(CODEC_ALONE)
    run(${configure} -S ${SOURCE_DIR} -DPCL_EXT_WITH_PCL=OFF ${without_pcl})
  endif()
  run(${CMAKE_COMMAND} --build ${BUILD_DIR})
  if(AS_SUBDIRECTORY)
    run_program(build/consumer)
    run_program(build/codec_consumer)
    run_program(build/recording_consumer)
    run_program(build/view_consumer)
    run_program(build/link_consumer)
  endif()
endif()
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/installed)
# So that pcl_ext view and receive --view need no --page.
if(EXISTS ${SOURCE_DIR}/viewer/dist/viewer.html AND EXISTS ${WORK_DIR}/installed/bin/pcl_ext
   AND NOT EXISTS ${WORK_DIR}/installed/share/pcl_ext/viewer.html)
  message(FATAL_ERROR "the viewer's page was built and is not installed")
endif()
# A path that was written into the installed files no longer exists.
file(RENAME ${WORK_DIR}/installed ${prefix})

file(GLOB target_files ${prefix}/${LIBDIR}/cmake/pcl_ext/pcl_ext*-targets.cmake)
foreach(target_file ${target_files})
  file(READ ${target_file} targets)
  expect_without("${targets}" ${target_file} COMPILE_OPTIONS COMPILE_DEFINITIONS
                 ${SOURCE_DIR} ${BUILD_DIR})
endforeach()

# The codec is of use without PCL, whether the rest is installed or not.
build_project(${packages}/codec_consumer codec_consumer ${without_pcl}
              -DINCLUDE_ALL_HEADERS=${CODEC_ALONE})
run_program(codec_consumer/codec_consumer)
build_project(${packages}/recording_consumer recording_consumer ${without_pcl})
run_program(recording_consumer/recording_consumer)
build_project(${packages}/view_consumer view_consumer ${without_pcl})
run_program(view_consumer/view_consumer)
build_project(${packages}/link_consumer link_consumer ${without_pcl})
run_program(link_consumer/link_consumer)
compile_with_pkg_config(pcl_ext_codec codec_consumer)
compile_with_pkg_config(pcl_ext_recording recording_consumer)
compile_with_pkg_config(pcl_ext_view view_consumer)
compile_with_pkg_config(pcl_ext_link link_consumer)
write_block(doc/site.md "#include <pcl_ext/compression/frame_decoder.h>" site.cpp)
run(${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${prefix}/${LIBDIR}/pkgconfig
    pkg-config --cflags pcl_ext_link)
string(STRIP "${output}" flags)
separate_arguments(flags UNIX_COMMAND "${CXX_FLAGS} ${flags}")
run(${CXX_COMPILER} -std=c++17 -fsyntax-only ${flags} ${WORK_DIR}/readme_source/site.cpp)
set(codec ${prefix}/${LIBDIR}/libpcl_ext_codec.so)
if(EXISTS ${codec})
  run(readelf -W --dynamic --dyn-syms ${codec})
  expect_without("${output}" ${codec} libpcl_common libpcl_octree libboost)
endif()

if(CODEC_ALONE)
  file(GLOB_RECURSE headers ${prefix}/include/*)
  foreach(header ${headers})
    file(READ ${header} text)
    expect_without("${text}" ${header} "<pcl/")
  endforeach()
  expect_find("" 0 "found: codec recording view link." ${without_pcl})
  expect_find("OPTIONAL_COMPONENTS pcl_ext" 0 "found: codec recording view link." ${without_pcl})
  expect_find("COMPONENTS pcl_ext" 1 "component pcl_ext is not installed")
  expect_find("COMPONENTS simulator" 1 "component simulator is not installed")
  return()
endif()

build_project(${packages}/consumer consumer)
run_program(consumer/consumer)
compile_with_pkg_config(pcl_ext consumer)
build_project(${packages}/simulator_consumer simulator_consumer)
run_program(simulator_consumer/simulator_consumer)
if(AS_SUBDIRECTORY)
  return() # what follows is the same for it
endif()

expect_find("" 0 "found: codec recording view link pcl_ext simulator.")
expect_find("OPTIONAL_COMPONENTS foo" 0 "found: codec recording view link pcl_ext simulator.")
expect_find("COMPONENTS codec OPTIONAL_COMPONENTS simulator" 0 "found: codec recording view link." ${without_pcl})
expect_find("COMPONENTS codec OPTIONAL_COMPONENTS pcl_ext" 0 "found: codec recording view link." ${without_pcl})
expect_find("COMPONENTS codec foo" 1 "unknown component 'foo': the components are codec,")
# Another compiler has the same names.
find_program(CLANG clang++)
if(CLANG)
  build_project(${packages}/consumer clang_consumer -DCMAKE_CXX_COMPILER=${CLANG})
  run_program(clang_consumer/consumer)
else()
  message(STATUS "clang++ was not found: no program is built with it")
endif()
write_block(README.md "#include <pcl_ext" app.cpp)
write_block(README.md "cmake_minimum" CMakeLists.txt)
build_project(${WORK_DIR}/readme_source readme)
run(${WORK_DIR}/readme/app)
if(NOT output MATCHES "^160[0-9]+ points, [0-9]+ bytes, [0-9]+ voxels\n$")
  message(FATAL_ERROR "the README's program prints:\n${output}")
endif()
build_project(${SOURCE_DIR}/examples examples)
run_program(examples/02_sensor_to_denoised_cloud)
