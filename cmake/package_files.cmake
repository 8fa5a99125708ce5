# cpack runs this when the files of the components lie in a folder each, before it makes
# packages of them. Adds to each package licence and changelogs in the form that Debian
# wants, and compresses manual pages.
cmake_minimum_required(VERSION 3.19)

# The libraries' folder was chosen when the project was configured.
if(NOT CPACK_PCL_EXT_PREFIX STREQUAL "/usr")
  message(FATAL_ERROR "packages are for /usr: configure with -DCMAKE_INSTALL_PREFIX=/usr, "
                      "as tools/package.sh does")
endif()

# Without the file's name and time, so that the same files make the same packages.
function(compress file)
  execute_process(COMMAND gzip -9nf ${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# In a copyright file a line of text begins with a space, and an empty one is a point.
file(READ ${CPACK_PCL_EXT_SOURCE_DIR}/LICENSE licence)
string(REGEX MATCH "Copyright \\(c\\) ([^\n]*)\n+(.*)" unused "${licence}")
set(holders "${CMAKE_MATCH_1}")
string(STRIP "${CMAKE_MATCH_2}" licence)
string(REPLACE "\n" "\n " licence " ${licence}")
string(REGEX REPLACE "\n +\n" "\n .\n" licence "${licence}")

set(version ${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC) # of SOURCE_DATE_EPOCH, if set

foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} prefix)
  set(installed ${CPACK_TEMPORARY_DIRECTORY}/${component}/usr)
  set(doc ${installed}/share/doc/${CPACK_DEBIAN_${prefix}_PACKAGE_NAME})
  file(
    WRITE ${doc}/copyright
    "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\n"
    "Upstream-Name: ${CPACK_PACKAGE_NAME}\n"
    "Upstream-Contact: ${CPACK_PACKAGE_CONTACT}\n\n"
    "Files: *\nCopyright: ${holders}\nLicense: BSD-3-clause\n${licence}\n")
  file(
    WRITE ${doc}/changelog.Debian
    "${CPACK_PACKAGE_NAME} (${version}) unstable; urgency=medium\n\n"
    "  * Built by cpack from pcl_ext ${CPACK_PACKAGE_VERSION}; what is new in it is in\n"
    "    changelog.gz.\n\n"
    " -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
  configure_file(${CPACK_PCL_EXT_SOURCE_DIR}/CHANGELOG.md ${doc}/changelog COPYONLY)
  file(GLOB_RECURSE manual_pages ${installed}/share/man/*.[1-9])
  set(written ${doc}/copyright ${doc}/changelog.Debian ${doc}/changelog)
  file(
    CHMOD ${written}
    PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
  list(REMOVE_ITEM written ${doc}/copyright)
  foreach(file ${written} ${manual_pages})
    compress(${file})
  endforeach()
  # Not those of the umask that cpack was run with.
  execute_process(
    COMMAND find ${CPACK_TEMPORARY_DIRECTORY}/${component} -type d -exec chmod 755 {} +
            COMMAND_ERROR_IS_FATAL ANY)
endforeach()
