// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief PCL_EXT_LANES_TARGET goes before functions that use the vectors of a lanes
 * type.
 *
 * It is empty but in the files named ..._avx2.cpp, which define PCL_EXT_TARGETS_AVX2
 * and instantiate these functions with Avx2Lanes and nothing else. Such files are
 * compiled by themselves, never as part of a unit of several files.
 *
 * An attribute rather than options of the compiler, because with options all inline
 * functions that the file emits would need AVX2, and of those that other files emit,
 * too, the linker keeps any. test/simd/check_avx2_objects.py checks what these files
 * emit.
 */
#pragma once

#if defined(PCL_EXT_TARGETS_AVX2)
#define PCL_EXT_LANES_TARGET [[gnu::target("avx2")]]
#else
#define PCL_EXT_LANES_TARGET
#endif
