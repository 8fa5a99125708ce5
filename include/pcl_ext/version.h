// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>

#if __cplusplus < 201703L && !(defined(_MSVC_LANG) && _MSVC_LANG >= 201703L)
#error "pcl_ext needs C++17: compile with -std=c++17 or a later standard"
#endif

/** \file
 * \brief The version of these headers, and that of the library which a program has
 * loaded. Libraries of one minor version can take each other's place.
 */
#define PCL_EXT_VERSION_MAJOR 0
#define PCL_EXT_VERSION_MINOR 3
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

/** \brief Inline namespace of all names: libraries whose binary interfaces differ have
 * other symbols, so that one of them is never taken for another. Files write
 * `namespace pcl_ext::PCL_EXT_ABI::io {`; programs need it only to add to a namespace. */
#define PCL_EXT_ABI PCL_EXT_ABI_OF_VERSION(PCL_EXT_VERSION_MAJOR, PCL_EXT_VERSION_MINOR)
#define PCL_EXT_ABI_OF_VERSION(major, minor) PCL_EXT_ABI_OF_NUMBERS(major, minor)
#define PCL_EXT_ABI_OF_NUMBERS(major, minor) v##major##_##minor

#if defined(__clang__)
// C++17 has no word for it in `namespace pcl_ext::PCL_EXT_ABI::io {`.
#pragma clang diagnostic ignored "-Winline-namespace-reopened-noninline"
#endif

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

/** \addtogroup common
 * @{ */

/** \brief PCL_EXT_VERSION_TEXT of the library that is loaded. */
PCL_EXT_CODEC_EXPORT const char*
version() noexcept;

/** @} */

} // namespace PCL_EXT_ABI
} // namespace pcl_ext
