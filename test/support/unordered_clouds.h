// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/compression/cloud_encoder.h>

#include "stream/frame_encoder.h"
#include "support/voxel_frames.h"

#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI::io::test {

class UnorderedClouds {
public:
  explicit UnorderedClouds(const EncoderSettings& settings)
  : voxelizer_(settings, IntensityUnit::None)
  , encoder_(settings.format, settings.i_frame_rate, settings.effort)
  {}

  std::size_t
  encode(const PointView& cloud, const WorldPose& pose)
  {
    VoxelFrame frame;
    EXPECT_TRUE(voxelizer_.voxelize(cloud, pose, frame).ok());
    return encoded(encoder_, frame).size();
  }

private:
  CloudEncoder voxelizer_;
  FrameEncoder encoder_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io::test
