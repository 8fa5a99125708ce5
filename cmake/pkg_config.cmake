# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Files for pkg-config, one for each library. They hold no absolute path, so that the
# folder of installation may be moved.
set(PCL_EXT_PKG_CONFIG_DIR ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

#   library           its name, which is that of the target
#   description       one line
#   requires          modules of pkg-config whose headers its headers include
#   static_libraries  what a static library needs besides when a program is linked
function(pcl_ext_install_pkg_config library description requires static_libraries)
  if(BUILD_SHARED_LIBS)
    set(static_libraries)
  endif()
  set(definitions)
  if(library STREQUAL pcl_ext AND NOT PCL_EXT_HAS_INSTANCES)
    set(definitions " -DPCL_EXT_NO_INSTANCES")
  endif()
  file(RELATIVE_PATH to_prefix ${CMAKE_INSTALL_PREFIX}/${PCL_EXT_PKG_CONFIG_DIR}
       ${CMAKE_INSTALL_PREFIX})
  string(REGEX REPLACE "/$" "" to_prefix "${to_prefix}")
  configure_file(${PROJECT_SOURCE_DIR}/cmake/pkg-config.pc.in ${library}.pc @ONLY)
  install(
    FILES ${CMAKE_CURRENT_BINARY_DIR}/${library}.pc
    DESTINATION ${PCL_EXT_PKG_CONFIG_DIR}
    COMPONENT dev)
endfunction()

pcl_ext_install_pkg_config(pcl_ext_codec "Voxel clouds to bytes and back, without PCL"
                           "eigen3 >= 3.3" " -lz -pthread")
if(PCL_EXT_WITH_RECORDING)
  set(bzip2_library)
  if(PCL_EXT_WITH_BZIP2)
    set(bzip2_library " -lbz2")
  endif()
  set(sqlite_library)
  if(PCL_EXT_WITH_SQLITE)
    set(sqlite_library " -lsqlite3")
  endif()
  pcl_ext_install_pkg_config(
    pcl_ext_recording "Recordings of voxel clouds: files of frames, MCAP, rosbag2 folders"
    "pcl_ext_codec = ${PROJECT_VERSION}" " -lzstd -llz4${bzip2_library}${sqlite_library} -lz")
endif()

if(PCL_EXT_WITH_VIEW)
  pcl_ext_install_pkg_config(
    pcl_ext_view "Server that shows recordings and streams of voxel clouds in browsers"
    "pcl_ext_codec = ${PROJECT_VERSION}" " -lz -pthread")
endif()

if(PCL_EXT_WITH_LINK)
  pcl_ext_install_pkg_config(
    pcl_ext_link "Streams of voxel clouds between machines, over a NATS server"
    "pcl_ext_codec = ${PROJECT_VERSION}" " -lnats -lz -pthread")
endif()

# PCL's modules are pcl_common, or pcl_common-1.12, by how PCL was installed.
if(PCL_EXT_WITH_PCL)
  set(version_of_pcl ${PCL_VERSION_MAJOR}.${PCL_VERSION_MINOR})
  find_file(
    PCL_EXT_PKG_CONFIG_OF_PCL
    NAMES pcl_octree.pc pcl_octree-${version_of_pcl}.pc
    HINTS ${PCL_DIR}/../.. ${PCL_DIR}/../../lib
    PATH_SUFFIXES pkgconfig
    NO_DEFAULT_PATH
    DOC "File of PCL's octree module for pkg-config")
  if(PCL_EXT_PKG_CONFIG_OF_PCL)
    get_filename_component(module_of_pcl ${PCL_EXT_PKG_CONFIG_OF_PCL} NAME_WLE)
    string(REPLACE octree common common_of_pcl ${module_of_pcl})
    pcl_ext_install_pkg_config(
      pcl_ext "PCL extension that compresses streams of clouds into voxels with intensity"
      "pcl_ext_codec = ${PROJECT_VERSION}, ${common_of_pcl} >= 1.12, ${module_of_pcl} >= 1.12"
      " -pthread")
  else()
    message(STATUS "PCL has no files for pkg-config: pcl_ext.pc is not installed")
  endif()
endif()
