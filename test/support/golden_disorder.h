// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "support/golden_stream.h"
#include "support/voxel_frames.h"

#include <optional>
#include <random>
#include <string>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io::test {

/** \brief Senders that are started again, whose frames come twice, late, damaged, cut
 * off, or not at all, with other bytes between them. */
inline GoldenStream
goldenDisorder(const std::string& name)
{
  GoldenStream stream{name, Effort::Fast, 3, {}};
  std::mt19937_64 random(61);
  const std::pair<Effort, int> senders[] = {
      {Effort::Fast, 8}, {Effort::Small, 6}, {Effort::Balanced, 5}};
  for (const auto& [effort, count] : senders) {
    VoxelFrame frame = randomFrame(random, 4, 20);
    for (int i = 0; i < count; ++i) {
      stream.frames.push_back({frame, std::nullopt, std::nullopt});
      if (i == 0)
        stream.frames.back().begins_sender = effort;
      walk(random, 2, frame);
    }
  }
  using Damage = Sending::Damage;
  // Frames 0, 3, 6, 8, 11, 14 and 17 are I-frames; 0, 8 and 14 have number 1.
  stream.sendings = {{0, true, Damage::None, "no frame PCX <HEAD PCXIPCXI<HEAD>"},
                     {1},
                     {1, false},
                     {2, false, Damage::InvertedBit},
                     {0, false},
                     {2, false, Damage::CutOff},
                     {2},
                     {4, false}, // it lacks its reference
                     {3},
                     {3}, // the last I-frame is decoded again
                     {4, true, Damage::None, "P"},
                     {5},
                     {3, false},
                     {6},
                     {7},
                     {8}, // the second sender
                     {6, false},
                     {9},
                     {10},
                     {11},
                     {12},
                     {13},
                     {15, false}, // the third one, whose first frame is lost
                     {17, false},
                     {17},
                     {18}};
  // The last I-frame again is a sign of another start after many old frames only.
  for (int i = 0; i < 23; ++i)
    stream.sendings.push_back({15, false});
  stream.sendings.push_back({17, false});
  stream.sendings.push_back({17});
  stream.sendings.push_back({18});
  return stream;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test
