// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/robot_cell.h"
#include "support/node_tests.h"

namespace {

using namespace pcl_ext;
using nodes::test::decodedWith;
using nodes::test::encoded;
using nodes::test::messageOf;
using nodes::test::runtimeKinect;

nodes::SensorNodeSettings
outlierSettingsOf(IntensityLaw law)
{
  nodes::SensorNodeSettings settings;
  settings.compression.resolution = 0.08;
  settings.law = law;
  settings.sensor = runtimeKinect();
  settings.crop_box = io::BoundingBox{{0.0, 0.0, 0.1}, {10.0, 10.0, 4.0}};
  return settings;
}

class CellCamera {
public:
  WorldPose
  pose() const
  {
    return WorldPose(cell_.sensorPose(1));
  }

  pcl::PointCloud<pcl::PointXYZ>
  capture(std::uint32_t frame)
  {
    cell::CellFrame captured;
    cell_.capture(1, frame, captured);
    return captured.cloud;
  }

private:
  cell::RobotCell cell_{1};
};

TEST(SensorNodeOutlierRemoval, SendsWhatTheFilterKeeps)
{
  for (const auto law : {IntensityLaw::Count, IntensityLaw::Quadratic}) {
    nodes::SensorNodeSettings settings = outlierSettingsOf(law);
    EXPECT_FALSE(settings.outlier_removal);
    nodes::SensorNode plain(settings);
    settings.outlier_removal.emplace();
    nodes::SensorNode filtering(settings);
    VoxelOutlierRemoval removal({densityUnitSettings(densityUnitOf(law))});
    io::FrameDecoder plain_decoder;
    io::FrameDecoder filtered_decoder;
    CellCamera camera;
    for (std::uint32_t i = 0; i < 5; ++i) {
      const pcl::PCLPointCloud2 cloud = messageOf(camera.capture(i));
      const auto bytes = encoded(plain, cloud, camera.pose());
      const auto filtered_bytes = encoded(filtering, cloud, camera.pose());
      EXPECT_LT(filtered_bytes.size(), bytes.size());
      io::VoxelFrame expected = decodedWith(plain_decoder, bytes);
      const io::VoxelFrame voxels = decodedWith(filtered_decoder, filtered_bytes);
      // The receiver's filter sees what the sensor's does.
      const std::size_t removed = removal.filter(expected).removed;
      EXPECT_GT(removed, 0u);
      EXPECT_EQ(filtering.statistics().outliers_removed, removed);
      EXPECT_EQ(plain.statistics().outliers_removed, 0u);
      EXPECT_EQ(voxels.keys, expected.keys);
      EXPECT_EQ(voxels.intensities, expected.intensities);
    }
  }
}

TEST(SensorNodeOutlierRemoval, TheQuadraticLawIsMeasuredInFacesInAnyLayout)
{
  nodes::SensorNodeSettings settings = outlierSettingsOf(IntensityLaw::Quadratic);
  settings.compression.format = io::StreamFormat::Published;
  const auto removedBy = [&](DensityUnit unit) {
    settings.outlier_removal.emplace().unit = densityUnitSettings(unit);
    nodes::SensorNode node(settings);
    CellCamera camera;
    encoded(node, messageOf(camera.capture(0)), camera.pose());
    return node.statistics().outliers_removed;
  };
  EXPECT_EQ(removedBy(DensityUnit::Automatic), removedBy(DensityUnit::Faces));
  EXPECT_NE(removedBy(DensityUnit::Automatic), removedBy(DensityUnit::Points));
}

TEST(SensorNodeOutlierRemoval, RaysBeginWhereTheSensorIs)
{
  nodes::SensorNodeSettings settings = outlierSettingsOf(IntensityLaw::Count);
  nodes::SensorNode plain(settings);
  settings.outlier_removal.emplace().unit = RaysUnit();
  nodes::SensorNode filtering(settings);
  settings.outlier_removal->unit = RaysUnit{{{0.0, 0.0, 50.0}}};
  nodes::SensorNode elsewhere(settings);
  RaysUnit rays;
  rays.intensities_are_counts = true;
  CellCamera camera;
  io::FrameDecoder decoder;
  for (std::uint32_t i = 0; i < 2; ++i) {
    WorldPose pose = camera.pose();
    pose.pretranslate(Eigen::Vector3d(0.3 * i, 0.0, 0.0)); // the sensor moves
    const pcl::PCLPointCloud2 cloud = messageOf(camera.capture(i));
    const io::VoxelFrame frame = decodedWith(decoder, encoded(plain, cloud, pose));
    encoded(filtering, cloud, pose);
    encoded(elsewhere, cloud, pose);
    const auto removedFrom = [&](const std::array<double, 3>& position) {
      rays.sensor_position = position;
      io::VoxelFrame voxels = frame;
      return VoxelOutlierRemoval({rays}).filter(voxels).removed;
    };
    const auto& at = pose.translation();
    const std::size_t removed = removedFrom({at.x(), at.y(), at.z()});
    EXPECT_GT(removed, 0u);
    EXPECT_EQ(filtering.statistics().outliers_removed, removed);
    EXPECT_EQ(elsewhere.statistics().outliers_removed, removedFrom({0.0, 0.0, 50.0}));
    EXPECT_NE(elsewhere.statistics().outliers_removed, removed);
  }
}

TEST(SensorNodeOutlierRemoval, TellsWhatVoxelsWereJudgedBy)
{
  for (const auto& [law, unit] :
       {std::pair(IntensityLaw::Linear, DensityUnit::Faces),
        std::pair(IntensityLaw::Count, DensityUnit::Points)}) {
    nodes::SensorNodeSettings settings = outlierSettingsOf(law);
    settings.outlier_removal.emplace();
    nodes::SensorNode node(settings);
    CellCamera camera;
    encoded(node, messageOf(camera.capture(0)), camera.pose());
    EXPECT_EQ(node.statistics().density_unit, unit);
  }
}

TEST(SensorNodeOutlierRemoval, VoxelsOfAnEdgeThatIsNotJudgedStayWithAWarning)
{
  nodes::SensorNodeSettings settings = outlierSettingsOf(IntensityLaw::Count);
  settings.compression.resolution = 0.25;
  settings.outlier_removal.emplace();
  nodes::SensorNode node(settings);
  CellCamera camera;
  std::vector<std::uint8_t> bytes;
  const auto status = node.encode(messageOf(camera.capture(0)), camera.pose(), bytes);
  EXPECT_EQ(status.message(),
            "outliers stay: resolution is 0.25; it must be 0.001 to 0.2 m for outliers "
            "to be removed from voxels");
  EXPECT_TRUE(node.statistics().outliers_stay);
  settings.outlier_removal->unit = PointsUnit();
  EXPECT_FALSE(nodes::SensorNode(settings).settingsStatus().ok());
}

TEST(SensorNodeOutlierRemoval, UnitsMustFitTheLaw)
{
  const std::tuple<IntensityLaw, DensityUnitSettings, std::string> cases[] = {
      {IntensityLaw::Count,
       FacesUnit(),
       "outlier_removal.unit is faces and law is count, whose intensities are numbers "
       "of points; choose automatic or points, or law quadratic"},
      {IntensityLaw::Native,
       FacesUnit(),
       "outlier_removal.unit is faces and law is native, whose intensities are no "
       "densities; choose automatic, voxels or rays, or law quadratic"},
      {IntensityLaw::None,
       PointsUnit(),
       "outlier_removal.unit is points and law is none, which has no intensities; "
       "choose automatic, voxels or rays, or law count"},
      {IntensityLaw::Linear,
       FacesUnit{{}, -1.0f},
       "outlier_removal: full_intensity is -1; it must be a finite number above 0"},
      {IntensityLaw::Linear, AutomaticUnit(), ""},
      {IntensityLaw::Quadratic, FacesUnit(), ""},
      {IntensityLaw::Count, PointsUnit(), ""}};
  const auto message_of = [](IntensityLaw law, const DensityUnitSettings& unit) {
    nodes::SensorNodeSettings settings = outlierSettingsOf(law);
    settings.outlier_removal.emplace().unit = unit;
    const nodes::SensorNode node(settings);
    EXPECT_EQ(node.settingsStatus().code() == nodes::SensorNodeCode::InvalidSettings,
              !node.settingsStatus().message().empty());
    return node.settingsStatus().message();
  };
  for (const auto& [law, unit, message] : cases)
    EXPECT_EQ(message_of(law, unit), message);
  for (const IntensityLaw law : {IntensityLaw::Native, IntensityLaw::None})
    for (const DensityUnit unit :
         {DensityUnit::Automatic, DensityUnit::Voxels, DensityUnit::Rays})
      EXPECT_EQ(message_of(law, densityUnitSettings(unit)), "");
}

} // namespace
