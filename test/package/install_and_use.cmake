# Installs the library into an empty prefix, moves the prefix, and there builds and runs
# projects with find_package(pcl_ext).
# Usage: cmake -DSOURCE_DIR=... -DWORK_DIR=... -DLIBDIR=... -DGENERATOR=...
#   -DCXX_COMPILER=... -DCXX_FLAGS=... [-DBUILD_DIR=...] [-DOPTIONS=...]
#   [-DCODEC_ALONE=ON] [-DWITH_EXAMPLES=ON] -P install_and_use.cmake
#   BUILD_DIR      a build tree; without it one is made with OPTIONS
#   CODEC_ALONE    without pcl_ext::pcl_ext, as on a machine that has no PCL
#   WITH_EXAMPLES  the examples are built and run, too

set(toolchain -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${CXX_COMPILER}
              -DCMAKE_CXX_FLAGS=${CXX_FLAGS} -DCMAKE_BUILD_TYPE=Release)
set(without_pcl -DCMAKE_DISABLE_FIND_PACKAGE_PCL=ON)
set(prefix ${WORK_DIR}/moved)

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output
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

function(expect_without text what)
  foreach(word ${ARGN})
    string(FIND "${text}" "${word}" position)
    if(NOT position EQUAL -1)
      message(FATAL_ERROR "${what} mentions '${word}':\n${text}")
    endif()
  endforeach()
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
if(NOT BUILD_DIR)
  set(BUILD_DIR ${WORK_DIR}/build)
  if(CODEC_ALONE)
    list(APPEND OPTIONS -DPCL_EXT_WITH_PCL=OFF ${without_pcl})
  else()
    list(APPEND OPTIONS -DPCL_EXT_BUILD_EXAMPLES=OFF -DPCL_EXT_BUILD_TOOLS=OFF)
  endif()
  run(${CMAKE_COMMAND} -S ${SOURCE_DIR} -B ${BUILD_DIR} ${toolchain}
      -DCMAKE_INSTALL_LIBDIR=${LIBDIR} ${OPTIONS})
  run(${CMAKE_COMMAND} --build ${BUILD_DIR})
endif()
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/installed)
# A path that was written into the installed files no longer exists.
file(RENAME ${WORK_DIR}/installed ${prefix})

file(GLOB target_files ${prefix}/${LIBDIR}/cmake/pcl_ext/pcl_ext*-targets.cmake)
foreach(target_file ${target_files})
  file(READ ${target_file} targets)
  expect_without("${targets}" ${target_file} COMPILE_OPTIONS COMPILE_DEFINITIONS
                 ${SOURCE_DIR} ${BUILD_DIR})
endforeach()

# The codec is of use without PCL, whether the rest is installed or not.
set(packages ${SOURCE_DIR}/test/package)
build_project(${packages}/codec_stranger codec_stranger ${without_pcl}
              -DINCLUDE_ALL_HEADERS=${CODEC_ALONE})
run(${WORK_DIR}/codec_stranger/codec_stranger)
message(STATUS "${output}")
set(codec ${prefix}/${LIBDIR}/libpcl_ext_codec.so)
if(EXISTS ${codec})
  run(readelf -W --dynamic --dyn-syms ${codec})
  expect_without("${output}" ${codec} libpcl_common libpcl_octree libboost pthread)
endif()

if(CODEC_ALONE)
  file(GLOB_RECURSE headers ${prefix}/include/*)
  foreach(header ${headers})
    file(READ ${header} text)
    expect_without("${text}" ${header} "<pcl/")
  endforeach()
  # The whole library is asked for, and is not there.
  execute_process(
    COMMAND ${CMAKE_COMMAND} -S ${packages}/stranger -B ${WORK_DIR}/stranger ${toolchain}
            -DCMAKE_PREFIX_PATH=${prefix}
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " output "${output}")
  string(FIND "${output}" "component pcl_ext is not installed" position)
  if(result EQUAL 0 OR position EQUAL -1)
    message(FATAL_ERROR "COMPONENTS pcl_ext ended with ${result}:\n${output}")
  endif()
  return()
endif()

build_project(${packages}/stranger stranger)
run(${WORK_DIR}/stranger/stranger)
message(STATUS "${output}")
if(WITH_EXAMPLES)
  build_project(${SOURCE_DIR}/examples examples)
  run(${WORK_DIR}/examples/02_sensor_to_denoised_cloud)
  message(STATUS "${output}")
endif()
