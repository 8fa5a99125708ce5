// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

/** \file
 * What the shared libraries export, with one macro for each library. CMake defines
 * pcl_ext_codec_EXPORTS and the like while a library is built, and PCL_EXT_STATIC for
 * users of static ones.
 */
#if defined(_WIN32) && !defined(PCL_EXT_STATIC)
#define PCL_EXT_DLL_EXPORT __declspec(dllexport)
#define PCL_EXT_DLL_IMPORT __declspec(dllimport)
#elif defined(__GNUC__) && !defined(_WIN32)
#define PCL_EXT_DLL_EXPORT __attribute__((visibility("default")))
#define PCL_EXT_DLL_IMPORT __attribute__((visibility("default")))
#else
#define PCL_EXT_DLL_EXPORT
#define PCL_EXT_DLL_IMPORT
#endif

#if defined(pcl_ext_codec_EXPORTS)
#define PCL_EXT_CODEC_EXPORT PCL_EXT_DLL_EXPORT
#else
#define PCL_EXT_CODEC_EXPORT PCL_EXT_DLL_IMPORT
#endif

#if defined(pcl_ext_recording_EXPORTS)
#define PCL_EXT_RECORDING_EXPORT PCL_EXT_DLL_EXPORT
#else
#define PCL_EXT_RECORDING_EXPORT PCL_EXT_DLL_IMPORT
#endif

#if defined(pcl_ext_view_EXPORTS)
#define PCL_EXT_VIEW_EXPORT PCL_EXT_DLL_EXPORT
#else
#define PCL_EXT_VIEW_EXPORT PCL_EXT_DLL_IMPORT
#endif

#if defined(pcl_ext_link_EXPORTS)
#define PCL_EXT_LINK_EXPORT PCL_EXT_DLL_EXPORT
#else
#define PCL_EXT_LINK_EXPORT PCL_EXT_DLL_IMPORT
#endif

#if defined(PCL_EXT_WITHOUT_PCL) // part of the program itself
#define PCL_EXT_EXPORT
#elif defined(pcl_ext_EXPORTS)
#define PCL_EXT_EXPORT PCL_EXT_DLL_EXPORT
#else
#define PCL_EXT_EXPORT PCL_EXT_DLL_IMPORT
#endif
