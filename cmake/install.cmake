# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# What `cmake --install` puts where, and how find_package(pcl_ext) and pkg-config find it.
# The components library, dev, tools and python are packages of their own, see debian/rules.
include(CMakePackageConfigHelpers)

set(PCL_EXT_CONFIG_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/pcl_ext)

# The codec's targets are a file of their own: COMPONENTS codec needs no PCL.
function(pcl_ext_install target file)
  install(
    TARGETS ${target}
    EXPORT ${file}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
            COMPONENT library
            NAMELINK_COMPONENT dev
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT library)
  install(
    EXPORT ${file}
    NAMESPACE pcl_ext::
    FILE ${file}.cmake
    DESTINATION ${PCL_EXT_CONFIG_DIR}
    COMPONENT dev)
endfunction()
pcl_ext_install(pcl_ext_codec pcl_ext-codec-targets)
if(PCL_EXT_WITH_RECORDING)
  pcl_ext_install(pcl_ext_recording pcl_ext-recording-targets)
endif()
if(PCL_EXT_WITH_VIEW)
  pcl_ext_install(pcl_ext_view pcl_ext-view-targets)
endif()
if(PCL_EXT_WITH_LINK)
  pcl_ext_install(pcl_ext_link pcl_ext-link-targets)
endif()
if(PCL_EXT_WITH_PCL)
  pcl_ext_install(pcl_ext pcl_ext-targets)
endif()
if(PCL_EXT_BUILD_SIMULATOR AND PCL_EXT_WITH_PCL)
  pcl_ext_install(pcl_ext_simulator pcl_ext-simulator-targets)
endif()

# Without PCL only the codec's headers are installed: none of them includes PCL's.
set(PCL_EXT_HEADERS_WITH_PCL
    nodes
    octree
    filters/impl
    cloud_outlier_removal.h
    cloud_sources.h
    cloud_streams.h
    colour_mean.h
    library_instances.h
    lidar_clouds.h
    octree_leaves.h
    octree_pointcloud_intensity_compression.h
    octree_pointcloud_intensity_compression.hpp
    pcl_conventions.h
    point_fields.h
    point_intensity.h
    point_types.h
    sensor_preprocessor.h)
set(left_out_headers)
if(NOT PCL_EXT_WITH_PCL)
  list(TRANSFORM PCL_EXT_HEADERS_WITH_PCL REPLACE "(.+)" "PATTERN;\\1;EXCLUDE"
       OUTPUT_VARIABLE left_out_headers)
endif()
if(NOT PCL_EXT_WITH_RECORDING)
  list(APPEND left_out_headers PATTERN recording EXCLUDE)
endif()
if(NOT PCL_EXT_WITH_VIEW)
  list(APPEND left_out_headers PATTERN view EXCLUDE)
endif()
if(NOT PCL_EXT_WITH_LINK)
  list(APPEND left_out_headers PATTERN link EXCLUDE)
endif()
install(
  DIRECTORY include/pcl_ext
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  COMPONENT dev ${left_out_headers})

set(PCL_EXT_IS_SHARED OFF)
if(BUILD_SHARED_LIBS)
  set(PCL_EXT_IS_SHARED ON)
endif()
configure_package_config_file(cmake/pcl_ext-config.cmake.in pcl_ext-config.cmake
                              INSTALL_DESTINATION ${PCL_EXT_CONFIG_DIR})
write_basic_package_version_file(pcl_ext-config-version.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/pcl_ext-config.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/pcl_ext-config-version.cmake
        DESTINATION ${PCL_EXT_CONFIG_DIR}
        COMPONENT dev)

include(${CMAKE_CURRENT_LIST_DIR}/pkg_config.cmake)

# For ROS workspaces, which find packages of build type cmake by their manifest.
install(
  FILES package.xml
  DESTINATION ${CMAKE_INSTALL_DATADIR}/pcl_ext
  COMPONENT dev)
# Debian packages have their own file of the licence.
install(
  FILES LICENSE
  DESTINATION ${CMAKE_INSTALL_DOCDIR}
  COMPONENT licence)
