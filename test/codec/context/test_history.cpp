// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/context/history.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <random>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::context;
using pcl_ext::io::test::below;

TEST(ContextHistory, ForgetsVoxelsBelowTheThreshold)
{
  // A voxel comes and goes at random until its probability is 1000 or 999, which golden
  // streams do not reach.
  std::mt19937_64 random(7);
  BlockList with;
  with.assign({7});
  const BlockList without;
  std::map<std::uint32_t, int> seen;
  for (int stream = 0; stream < 20000; ++stream) {
    History history;
    history.clear(8);
    history.update(with, {5}, nullptr, false);
    std::uint32_t probability = 26000;
    for (int age = 0; age < 60 && probability >= 1000; ++age) {
      const unsigned int shift = age < 2 ? 1 : age < 5 ? 2 : age < 10 ? 3 : 4;
      if (below(random, 8) == 0) {
        probability += (65535 - probability) >> shift;
        history.update(with, {5}, nullptr, false);
      }
      else {
        probability -= probability >> shift;
        history.update(without, {}, nullptr, false);
      }
      ASSERT_EQ(history.recordCount(), probability >= 1000 ? 1u : 0u);
      ++seen[probability];
    }
  }
  EXPECT_GT(seen[1000], 0);
  EXPECT_GT(seen[999], 0);
}

} // namespace
