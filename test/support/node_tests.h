// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "stream/frame_encoder.h"
#include "support/central_streams.h"
#include "support/fake_clock.h"
#include "support/sensor_clouds.h"
#include "support/test_memory.h"
#include "support/voxel_frames.h"
#include "support/world_voxels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes::test {

using namespace nodes;
using namespace std::chrono_literals;

using io::BoundingBox;
using io::Effort;
using io::FrameDecoder;
using io::FrameEncoder;
using io::isConsistent;
using io::StreamFormat;
using io::test::below;
using io::test::expectSameFrame;
using pcl_ext::AutomaticUnit;
using pcl_ext::FacesUnit;
using pcl_ext::IntensityLaw;
using pcl_ext::PointsUnit;
using pcl_ext::removeVoxelsBelow;
using pcl_ext::RuntimeSensor;
using pcl_ext::VoxelOutlierRemoval;
using pcl_ext::VoxelOutlierRemovalSettings;
using pcl_ext::WorldPose;
using pcl_ext::test::addVoxels;
using pcl_ext::test::Exemption;
using pcl_ext::test::FailingAllocation;
using pcl_ext::test::naiveVoxels;
using pcl_ext::test::WorldVoxels;
using pcl_ext::test::worldVoxels;

} // namespace pcl_ext::PCL_EXT_ABI::nodes::test
