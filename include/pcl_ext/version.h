#pragma once

#include <pcl_ext/export.h>

/** \file
 * \brief The version of these headers, and that of the library which a program has loaded.
 * Libraries of one minor version can take each other's place.
 */
#define PCL_EXT_VERSION_MAJOR 0
#define PCL_EXT_VERSION_MINOR 2
#define PCL_EXT_VERSION_PATCH 0

/** \brief A number to compare: 1.2.3 is 10203. */
#define PCL_EXT_VERSION                                                                \
  (PCL_EXT_VERSION_MAJOR * 10000 + PCL_EXT_VERSION_MINOR * 100 + PCL_EXT_VERSION_PATCH)

#define PCL_EXT_TEXT_OF_NUMBER(number) #number
#define PCL_EXT_TEXT_OF_VERSION(major, minor, patch)                                   \
  PCL_EXT_TEXT_OF_NUMBER(major)                                                        \
  "." PCL_EXT_TEXT_OF_NUMBER(minor) "." PCL_EXT_TEXT_OF_NUMBER(patch)

/** \brief A text, such as "1.2.3". */
#define PCL_EXT_VERSION_TEXT                                                           \
  PCL_EXT_TEXT_OF_VERSION(                                                             \
      PCL_EXT_VERSION_MAJOR, PCL_EXT_VERSION_MINOR, PCL_EXT_VERSION_PATCH)

namespace pcl_ext {

/** \brief PCL_EXT_VERSION_TEXT of the library that is loaded. */
PCL_EXT_EXPORT const char*
version() noexcept;

} // namespace pcl_ext
