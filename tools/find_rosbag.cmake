# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Bags of ROS 1 are read where Debian's librosbag-storage-dev is installed. Its package for
# CMake is not used, as it needs Python modules that may be missing.
# Sets PCL_EXT_ROSBAG_LIBRARIES, empty if it is not there, and PCL_EXT_ROSBAG_HEADERS.
option(PCL_EXT_WITH_ROS1_BAGS "Read bags of ROS 1 where rosbag_storage is found" ON)
set(PCL_EXT_ROSBAG_LIBRARIES)
set(PCL_EXT_ROSBAG_HEADERS)
if(NOT PCL_EXT_WITH_ROS1_BAGS)
  return()
endif()
foreach(header rosbag/view.h pluginlib/class_loader.hpp class_loader/class_loader.hpp
        rcpputils/shared_library.hpp rcutils/shared_library.h
        ament_index_cpp/get_package_prefix.hpp)
  get_filename_component(folder ${header} DIRECTORY)
  find_path(PCL_EXT_${folder}_HEADERS ${header} PATH_SUFFIXES ${folder})
  mark_as_advanced(PCL_EXT_${folder}_HEADERS)
  list(APPEND PCL_EXT_ROSBAG_HEADERS ${PCL_EXT_${folder}_HEADERS})
endforeach()
foreach(name rosbag_storage roscpp_serialization rostime cpp_common console_bridge)
  find_library(PCL_EXT_${name}_LIBRARY ${name})
  mark_as_advanced(PCL_EXT_${name}_LIBRARY)
  list(APPEND PCL_EXT_ROSBAG_LIBRARIES ${PCL_EXT_${name}_LIBRARY})
endforeach()
list(REMOVE_DUPLICATES PCL_EXT_ROSBAG_HEADERS)
include(CheckCXXSourceCompiles)
set(CMAKE_REQUIRED_INCLUDES ${PCL_EXT_ROSBAG_HEADERS})
set(CMAKE_REQUIRED_LIBRARIES ${PCL_EXT_ROSBAG_LIBRARIES})
set(CMAKE_REQUIRED_FLAGS -std=c++17)
set(CMAKE_REQUIRED_QUIET ON)
if(NOT PCL_EXT_ROSBAG_LIBRARIES MATCHES NOTFOUND
   AND NOT PCL_EXT_ROSBAG_HEADERS MATCHES NOTFOUND)
  check_cxx_source_compiles(
    "#include <rosbag/bag.h>
     #include <rosbag/view.h>
     int main() { rosbag::Bag bag; return rosbag::View(bag).size(); }"
    PCL_EXT_ROSBAG_COMPILES)
endif()
if(NOT PCL_EXT_ROSBAG_COMPILES)
  set(PCL_EXT_ROSBAG_LIBRARIES)
  message(STATUS "No rosbag_storage: the program pcl_ext will not read bags of ROS 1")
endif()
