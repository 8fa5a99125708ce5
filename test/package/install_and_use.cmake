# Installs the library into an empty prefix, moves the prefix, and there builds and runs a
# stranger's project and the examples with find_package(pcl_ext).
# Usage: cmake -DSOURCE_DIR=... -DWORK_DIR=... -DLIBDIR=... -DGENERATOR=...
#   -DCXX_COMPILER=... -DCXX_FLAGS=... [-DBUILD_DIR=...] -P install_and_use.cmake
# Without BUILD_DIR a static library is built first.

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output
                  ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGN}\nended with ${result}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(toolchain -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${CXX_COMPILER}
              -DCMAKE_CXX_FLAGS=${CXX_FLAGS} -DCMAKE_BUILD_TYPE=Release)

file(REMOVE_RECURSE ${WORK_DIR})
if(NOT BUILD_DIR)
  set(BUILD_DIR ${WORK_DIR}/build)
  run(${CMAKE_COMMAND} -S ${SOURCE_DIR} -B ${BUILD_DIR} ${toolchain} -DBUILD_SHARED_LIBS=OFF
      -DCMAKE_INSTALL_LIBDIR=${LIBDIR} -DPCL_EXT_BUILD_EXAMPLES=OFF -DPCL_EXT_BUILD_TOOLS=OFF
      -DPCL_EXT_BUILD_BENCHMARKS=OFF)
  run(${CMAKE_COMMAND} --build ${BUILD_DIR})
endif()
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/installed)
# A prefix that was moved shows whether anything remembers where it was.
file(RENAME ${WORK_DIR}/installed ${WORK_DIR}/moved)

file(READ ${WORK_DIR}/moved/${LIBDIR}/cmake/pcl_ext/pcl_ext-targets.cmake targets)
foreach(leak "COMPILE_OPTIONS" "COMPILE_DEFINITIONS" "${SOURCE_DIR}" "${BUILD_DIR}")
  string(FIND "${targets}" "${leak}" position)
  if(NOT position EQUAL -1)
    message(FATAL_ERROR "the exported target mentions '${leak}':\n${targets}")
  endif()
endforeach()

foreach(project ${SOURCE_DIR}/test/package/stranger ${SOURCE_DIR}/examples)
  get_filename_component(name ${project} NAME)
  run(${CMAKE_COMMAND} -S ${project} -B ${WORK_DIR}/${name} ${toolchain}
      -DCMAKE_PREFIX_PATH=${WORK_DIR}/moved)
  run(${CMAKE_COMMAND} --build ${WORK_DIR}/${name})
endforeach()
run(${WORK_DIR}/stranger/stranger)
message(STATUS "${output}")
run(${WORK_DIR}/examples/02_sensor_to_denoised_cloud)
message(STATUS "${output}")
