// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outliers/direction_depths.h"

#include "bytes/reserve_ahead.h"

namespace pcl_ext::PCL_EXT_ABI {

void
DirectionDepths::add(const Batch& points, std::size_t count, float least_depth)
{
  std::array<std::uint32_t, batch_size> squares;
  std::array<float, batch_size> depths;
  // Of all, as loops of a fixed length are vectorized.
  for (std::size_t i = 0; i < batch_size; ++i) {
    const Direction direction = directionOf(points[0][i], points[1][i], points[2][i]);
    squares[i] = direction.square;
    depths[i] = direction.depth;
  }
  io::ensureSize(squares_, count_ + count);
  std::uint32_t* const seen = squares_.data();
  std::size_t seen_count = count_;
  for (std::size_t i = 0; i < count; ++i) {
    if (!(depths[i] >= least_depth))
      continue;
    std::vector<float>& face = faces_[squares[i] / face_size];
    if (face.empty())
      face.assign(face_size, unseen);
    float& depth = face[squares[i] % face_size];
    // Without a branch, which would be mispredicted.
    seen[seen_count] = squares[i];
    seen_count += static_cast<std::size_t>(depth == unseen);
    depth = std::min(depth, depths[i]);
  }
  count_ = seen_count;
}

} // namespace pcl_ext::PCL_EXT_ABI
