// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "simd/lanes.h"
#include "simd/vector_choice.h"

#include <gtest/gtest.h>

#include <type_traits>

namespace pcl_ext::test {

/** \brief Names a lanes type, which need not be complete. */
template <typename LanesT>
struct LanesOf {
  using Lanes = LanesT;
};

/** \brief All lanes types that the library is built with, for typed tests. */
#if PCL_EXT_HAS_AVX2
using AllLanes =
    ::testing::Types<LanesOf<ScalarLanes>, LanesOf<NativeLanes>, LanesOf<Avx2Lanes>>;
#else
using AllLanes = ::testing::Types<LanesOf<ScalarLanes>, LanesOf<NativeLanes>>;
#endif

/** \brief The tests with lanes that this machine lacks are reported as skipped. */
template <typename LanesOfT>
class TestOfLanes : public ::testing::Test {
protected:
  void
  SetUp() override
  {
    if (std::is_same_v<typename LanesOfT::Lanes, Avx2Lanes> && !hasAvx2())
      GTEST_SKIP() << "this machine has no AVX2";
  }
};

} // namespace pcl_ext::test
