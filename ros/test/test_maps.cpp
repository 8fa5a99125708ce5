/** \file
 * \brief The OctoMap that the decompressor keeps, as OctoMap reads it.
 */
#include <pcl_ext/nodes/octomap_insertion.h>

#include "stream_scenario.h"

#include <octomap/OcTree.h>
#include <ros/service.h>
#include <std_srvs/Trigger.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>

namespace pcl_ext_ros {
namespace test {

namespace {

namespace fs = std::filesystem;

class Maps : public StreamScenario {
protected:
  Maps() : path(std::string(std::getenv("ROS_HOME")) + space + ".ot")
  {
    fs::remove(path);
  }

  Parameters
  mapParameters() const
  {
    return {{"map_path", path}, {"map_rate", 20.0}};
  }

  std_srvs::Trigger
  writeMap() const
  {
    const std::string service = full("decompressor/write_map");
    std_srvs::Trigger call;
    EXPECT_TRUE(ros::service::waitForService(service, ros::Duration(seconds_to_wait)));
    EXPECT_TRUE(ros::service::call(service, call));
    return call;
  }

  std::unique_ptr<octomap::OcTree>
  readMap() const
  {
    octomap::AbstractOcTree* const tree = octomap::AbstractOcTree::read(path);
    auto* const occupancy = dynamic_cast<octomap::OcTree*>(tree);
    EXPECT_NE(occupancy, nullptr) << path;
    if (occupancy == nullptr)
      delete tree;
    return std::unique_ptr<octomap::OcTree>(occupancy);
  }

  /** \brief The map of one frame by the library. */
  octomap::OcTree
  directMap(const sensor_msgs::PointCloud2& cloud,
            float full_intensity,
            const std::optional<octomap::point3d>& origin = std::nullopt) const
  {
    octomap::OcTree tree(0.04);
    pcl_ext::nodes::insertVoxels(
        DirectStream(compressorSettings()).frameOf(cloud, pose),
        full_intensity,
        origin,
        tree);
    tree.prune();
    return tree;
  }

  /** \brief Expects the nodes of a map with their log-odds. */
  static void
  expectSameMap(const octomap::OcTree& map, const octomap::OcTree& expected)
  {
    EXPECT_EQ(map.getResolution(), expected.getResolution());
    EXPECT_EQ(map.size(), expected.size());
    std::size_t wrong = 0;
    for (auto leaf = expected.begin_leafs(); leaf != expected.end_leafs(); ++leaf) {
      const octomap::OcTreeNode* const node =
          map.search(leaf.getKey(), leaf.getDepth());
      wrong += node == nullptr || node->getLogOdds() != leaf->getLogOdds() ? 1 : 0;
    }
    EXPECT_EQ(wrong, 0u);
  }

  const std::string path;
};

TEST_F(Maps, ServiceWritesTheLibrarysMap)
{
  transforms.set(sensor_frame, pose);
  startCompressor();
  startDecompressor(mapParameters() + Parameters{{"map_full_intensity", 2.0}});
  ASSERT_TRUE(show(cloud(0))) << decompressor->output();
  const std_srvs::Trigger call = writeMap();
  EXPECT_TRUE(call.response.success) << call.response.message;
  EXPECT_NE(call.response.message.find(path), std::string::npos)
      << call.response.message;
  const auto map = readMap();
  ASSERT_TRUE(map);
  expectSameMap(*map, directMap(cloud(0), 2.0f));
  // A voxel of many points is occupied for everybody who reads the map.
  std::size_t occupied = 0;
  for (const auto& voxel : voxelsIn(*voxels[0]))
    if (voxel[3] >= 2.0f) {
      const auto* const leaf = map->search(voxel[0], voxel[1], voxel[2]);
      ASSERT_NE(leaf, nullptr);
      EXPECT_TRUE(map->isNodeOccupied(leaf));
      ++occupied;
    }
  EXPECT_GT(occupied, 100u);
  EXPECT_FALSE(fs::exists(path + ".part"));
}

TEST_F(Maps, RaysFromTheSensorAreFree)
{
  transforms.set(sensor_frame, pose);
  startCompressor();
  XmlRpc::XmlRpcValue entry;
  entry["topic"] = compressed;
  entry["sensor_frame"] = sensor_frame;
  startDecompressor(mapParameters() +
                    Parameters{{"streams", listOf({entry})}, {"tf_timeout", 10.0}});
  ASSERT_TRUE(show(cloud(0))) << decompressor->output();
  EXPECT_TRUE(writeMap().response.success);
  const Eigen::Vector3f origin = pose.translation().cast<float>();
  const octomap::point3d sensor(origin.x(), origin.y(), origin.z());
  const auto map = readMap();
  ASSERT_TRUE(map);
  expectSameMap(*map, directMap(cloud(0), 4.0f, sensor));
  const auto* const before_wall =
      map->search(sensor + (octomap::point3d(voxelsIn(*voxels[0])[50].data()[0],
                                             voxelsIn(*voxels[0])[50].data()[1],
                                             voxelsIn(*voxels[0])[50].data()[2]) -
                            sensor) *
                               0.3f);
  ASSERT_NE(before_wall, nullptr);
  EXPECT_FALSE(map->isNodeOccupied(before_wall));
}

TEST_F(Maps, ServiceTakesWhatTheMapHasNotTakenByItself)
{
  transforms.set(sensor_frame, pose);
  startCompressor();
  startDecompressor(mapParameters() +
                    Parameters{{"map_rate", 0.001}, {"max_merge_age", 3600.0}});
  ASSERT_TRUE(show(cloud(0))) << decompressor->output();
  EXPECT_TRUE(writeMap().response.success);
  const auto map = readMap();
  ASSERT_TRUE(map);
  expectSameMap(*map, directMap(cloud(0), 4.0f));
}

TEST_F(Maps, ShutdownWritesTheMap)
{
  transforms.set(sensor_frame, pose);
  startCompressor();
  startDecompressor(mapParameters());
  ASSERT_TRUE(show(cloud(0))) << decompressor->output();
  EXPECT_FALSE(fs::exists(path));
  EXPECT_EQ(decompressor->interrupt(), 0) << decompressor->output();
  EXPECT_NE(decompressor->output().find(path), std::string::npos)
      << decompressor->output();
  const auto map = readMap();
  ASSERT_TRUE(map);
  expectSameMap(*map, directMap(cloud(0), 4.0f));
}

TEST_F(Maps, AnEmptyMapTakesNoOthersPlace)
{
  std::ofstream(path) << "yesterday's";
  startDecompressor(mapParameters());
  EXPECT_EQ(decompressor->interrupt(), 0) << decompressor->output();
  std::ifstream file(path);
  std::string kept;
  std::getline(file, kept);
  EXPECT_EQ(kept, "yesterday's");
}

TEST_F(Maps, FileThatCannotBeWrittenIsTold)
{
  transforms.set(sensor_frame, pose);
  startCompressor();
  const std::string folder = std::string(std::getenv("ROS_HOME")) + space;
  ASSERT_TRUE(fs::create_directory(folder));
  startDecompressor({{"map_path", folder + "/map.ot"}});
  ASSERT_TRUE(show(cloud(0)));
  fs::remove(folder);
  const std_srvs::Trigger call = writeMap();
  EXPECT_FALSE(call.response.success);
  EXPECT_NE(call.response.message.find(folder), std::string::npos)
      << call.response.message;
  EXPECT_TRUE(show(cloud(1)));
  EXPECT_EQ(decompressor->interrupt(), 1) << decompressor->output();
}

TEST_F(Maps, ServiceWithoutAMapSaysWhy)
{
  startBoth();
  const std_srvs::Trigger call = writeMap();
  EXPECT_FALSE(call.response.success);
  EXPECT_NE(call.response.message.find("map_path"), std::string::npos)
      << call.response.message;
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros
