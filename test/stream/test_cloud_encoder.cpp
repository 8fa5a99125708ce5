#include <pcl_ext/compression/cloud_encoder.h>

#include <gtest/gtest.h>

#include <array>

namespace {

using namespace pcl_ext::io;

/** \brief The voxels of one point, with a law of the depth. */
VoxelFrame
voxelizeOnePoint(StreamFormat format)
{
  IntensityCompressionSettings settings;
  settings.format = format;
  settings.depth_law = DepthLaw{2, 10.0, 255.0};
  CloudEncoder encoder(settings, pcl_ext::IntensityUnit::Share);
  const std::array<float, 3> point{0.1f, 0.2f, 3.0f};
  PointView view;
  view.coordinates = point.data();
  view.coordinate_stride = point.size();
  view.count = 1;
  VoxelFrame frame;
  EXPECT_TRUE(encoder.voxelize(view, pcl_ext::WorldPose::Identity(), frame).ok());
  EXPECT_EQ(frame.size(), 1u);
  return frame;
}

TEST(CloudEncoder, FramesHaveADepthModelInVersion1Only)
{
  EXPECT_TRUE(voxelizeOnePoint(StreamFormat::Version1).depth_model.has_value());
  EXPECT_FALSE(voxelizeOnePoint(StreamFormat::Published).depth_model.has_value());
}

} // namespace
