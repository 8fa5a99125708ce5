# Debian packages, by cpack: one for each component of what is installed. tools/package.sh
# builds and checks them, test/package/clean_root.sh installs and uses them.
if(NOT BUILD_SHARED_LIBS OR CMAKE_VERSION VERSION_LESS 3.19)
  return()
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME pcl-ext)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "") # each package has its own
set(CPACK_PACKAGE_CONTACT "the pcl_ext maintainers <maintainers@pcl-ext.example>")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_COMPONENTS_ALL library dev)
set(CPACK_STRIP_FILES ON)
# It adds what only packages have: licence, changelog, compressed manual pages.
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/package_files.cmake)
set(CPACK_PCL_EXT_SOURCE_DIR ${PROJECT_SOURCE_DIR})
set(CPACK_PCL_EXT_PREFIX ${CMAKE_INSTALL_PREFIX})

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SOURCE pcl-ext)
# Below the 1 that packages of Debian itself would begin with.
set(CPACK_DEBIAN_PACKAGE_RELEASE 0upstream1)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
# What is linked with is looked up in the packages that are installed. This project's own
# libraries are in none yet: components depend on the component library by name.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
get_property(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS GLOBAL
             PROPERTY PCL_EXT_LIBRARY_DIRS)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)
# For the packages of other programs.
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")

set(about_the_project
    "pcl_ext compresses streams of 3D sensor clouds into voxels, each with an
intensity: a measure of its reliability, or the sensor's own.
")

# After the macro's arguments come the lines of the description.
macro(pcl_ext_describe_package component name section synopsis)
  string(TOUPPER ${component} prefix)
  string(JOIN "\n" lines ${ARGN})
  set(CPACK_DEBIAN_${prefix}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${prefix}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${prefix}_DESCRIPTION "${synopsis}\n${about_the_project}\n${lines}")
endmacro()

# Its name has the number in the libraries' SONAME, so that the package of the next minor
# version can be installed beside it.
pcl_ext_describe_package(
  library libpcl-ext${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} libs
  "compression of 3D sensor clouds - shared libraries"
  "This package has the libraries that programs need to run.")
set(triggers ${PROJECT_BINARY_DIR}/packages.control/triggers)
file(WRITE ${triggers} "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${triggers})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_MULTIARCH same) # needs CMake 3.31

# What the public headers include, which is also what find_package(pcl_ext) looks for.
pcl_ext_describe_package(
  dev libpcl-ext-dev libdevel "compression of 3D sensor clouds - development files"
  "This package has the headers, and the files for CMake and pkg-config.")
set(CPACK_COMPONENT_DEV_DEPENDS library)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libeigen3-dev (>= 3.3)")
if(PCL_EXT_WITH_PCL)
  string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
         ", libpcl-dev (>= 1.12), libboost-dev (>= 1.65)")
endif()

if(PCL_EXT_BUILD_TOOLS)
  list(APPEND CPACK_COMPONENTS_ALL tools)
  pcl_ext_describe_package(
    tools pcl-ext-tools utils "compression of 3D sensor clouds - programs"
    "This package has the programs that encode and decode clouds in files.")
  set(CPACK_COMPONENT_TOOLS_DEPENDS library)
  set(CPACK_DEBIAN_TOOLS_PACKAGE_MULTIARCH foreign)
endif()

# The module is compiled for one minor version of Python. The package's scripts write and
# delete Python's byte code, of which dpkg knows nothing.
if(TARGET pcl_ext_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  pcl_ext_describe_package(
    python python3-pcl-ext python "compression of 3D sensor clouds - Python module"
    "This package has the module pcl_ext for Python 3.")
  set(CPACK_COMPONENT_PYTHON_DEPENDS library)
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  math(EXPR next_minor_version "${Python3_VERSION_MINOR} + 1")
  string(JOIN ", " CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
         "python3 (>= 3.${Python3_VERSION_MINOR})" "python3 (<< 3.${next_minor_version})"
         python3-numpy)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
      ${CMAKE_CURRENT_LIST_DIR}/python_package/postinst
      ${CMAKE_CURRENT_LIST_DIR}/python_package/prerm)
endif()

include(CPack)
