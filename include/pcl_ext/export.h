#pragma once

/** \file
 * PCL_EXT_EXPORT marks what the shared libraries export.
 */
#if defined(__GNUC__)
#define PCL_EXT_EXPORT __attribute__((visibility("default")))
#else
#define PCL_EXT_EXPORT
#endif
