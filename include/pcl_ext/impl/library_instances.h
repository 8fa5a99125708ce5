// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Whether a program may use the instances of templates that the library has.
 */
#pragma once

#include <Eigen/Core>

/** \brief 1 where layout and memory of clouds are those of the library's instances.
 *
 * These macros of Eigen decide: how Eigen::aligned_allocator, which has the points, and
 * operator new of clouds allocate (EIGEN_DEFAULT_ALIGN_BYTES,
 * EIGEN_MALLOC_ALREADY_ALIGNED), and how vectors of floats are aligned
 * (EIGEN_MAX_ALIGN_BYTES, EIGEN_MAX_STATIC_ALIGN_BYTES). Here all are as on a 64-bit
 * machine without AVX, and the memory is that of malloc. A program with other values, as
 * with -mavx or with the address sanitizer, instantiates for itself. So does one that
 * defines PCL_NO_PRECOMPILE. Where the library itself has other values, it has no
 * instances, and CMake and pkg-config define PCL_EXT_NO_INSTANCES for its users. */
#if !defined(PCL_NO_PRECOMPILE) && !defined(PCL_EXT_NO_INSTANCES) &&                   \
    EIGEN_MALLOC_ALREADY_ALIGNED && EIGEN_DEFAULT_ALIGN_BYTES == 16 &&                 \
    EIGEN_MAX_ALIGN_BYTES == 16 && EIGEN_MAX_STATIC_ALIGN_BYTES == 16
#define PCL_EXT_USES_INSTANCES 1
#else
#define PCL_EXT_USES_INSTANCES 0
#endif
