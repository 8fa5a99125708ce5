#pragma once

/** \file
 * Marks what the shared library exports; everything else in it is hidden.
 */
#if defined(__GNUC__)
#define PCL_EXT_EXPORT __attribute__((visibility("default")))
#else
#define PCL_EXT_EXPORT
#endif
