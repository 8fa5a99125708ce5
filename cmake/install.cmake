# What `cmake --install` puts where, and how find_package(pcl_ext) finds it.
include(CMakePackageConfigHelpers)

set(PCL_EXT_CONFIG_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/pcl_ext)

install(
  TARGETS pcl_ext
  EXPORT pcl_ext_targets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY include/pcl_ext DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(
  EXPORT pcl_ext_targets
  NAMESPACE pcl_ext::
  FILE pcl_ext-targets.cmake
  DESTINATION ${PCL_EXT_CONFIG_DIR})

configure_package_config_file(cmake/pcl_ext-config.cmake.in pcl_ext-config.cmake
                              INSTALL_DESTINATION ${PCL_EXT_CONFIG_DIR})
write_basic_package_version_file(pcl_ext-config-version.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/pcl_ext-config.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/pcl_ext-config-version.cmake
        DESTINATION ${PCL_EXT_CONFIG_DIR})

# For ROS workspaces, which find packages of build type cmake by their manifest.
install(FILES package.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/pcl_ext)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
