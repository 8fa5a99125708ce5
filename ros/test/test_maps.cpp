/** \file
 * \brief The OctoMap file that the decompressor writes.
 */
#include <pcl_ext/nodes/octomap_insertion.h>

#include "stream_scenario.h"

#include <octomap/OcTree.h>
#include <ros/service.h>
#include <std_srvs/Trigger.h>

#include <filesystem>
#include <fstream>
#include <memory>

namespace pcl_ext_ros1 {
namespace test {

namespace {

namespace fs = std::filesystem;

class Maps : public StreamScenario {
protected:
  Maps() : path(temporaryFolder() + space + ".ot") {}

  /** \brief Starts the nodes with a map, and shows one cloud. */
  void
  startWithMap(const Parameters& parameters = {})
  {
    startBoth({}, Parameters{{"map_path", path}, {"map_rate", 20.0}} + parameters);
    ASSERT_TRUE(show(cloud(0))) << decompressor->output();
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

  /** \brief Reads the file into `map`; expects the library's map of cloud(0), node by
   * node. */
  void
  expectMap(float full_intensity,
            const std::optional<octomap::point3d>& origin = std::nullopt)
  {
    octomap::OcTree expected(0.04);
    pcl_ext::nodes::insertVoxels(
        direct.frameOf(cloud(0), pose), full_intensity, origin, expected);
    expected.prune();

    std::unique_ptr<octomap::AbstractOcTree> tree(octomap::AbstractOcTree::read(path));
    auto* const occupancy = dynamic_cast<octomap::OcTree*>(tree.get());
    ASSERT_NE(occupancy, nullptr) << path;
    tree.release();
    map.reset(occupancy);
    EXPECT_EQ(map->getResolution(), expected.getResolution());
    EXPECT_EQ(map->size(), expected.size());
    std::size_t wrong = 0;
    for (auto leaf = expected.begin_leafs(); leaf != expected.end_leafs(); ++leaf) {
      const auto* const found = map->search(leaf.getKey(), leaf.getDepth());
      wrong += found == nullptr || found->getLogOdds() != leaf->getLogOdds() ? 1 : 0;
    }
    EXPECT_EQ(wrong, 0u);
  }

  const std::string path;
  std::unique_ptr<octomap::OcTree> map;
};

TEST_F(Maps, ServiceWritesTheLibrarysMap)
{
  ASSERT_NO_FATAL_FAILURE(startWithMap({{"map_full_intensity", 2.0}}));
  const std_srvs::Trigger call = writeMap();
  EXPECT_TRUE(call.response.success) << call.response.message;
  EXPECT_NE(call.response.message.find(path), std::string::npos)
      << call.response.message;
  ASSERT_NO_FATAL_FAILURE(expectMap(2.0f));
  // Voxels of the full intensity are occupied.
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
  ASSERT_NO_FATAL_FAILURE(startWithMap(
      {{"streams", listOf({streamEntry(compressed, "sensor_frame", sensor_frame)})},
       {"tf_timeout", 10.0}}));
  EXPECT_TRUE(writeMap().response.success);
  const Eigen::Vector3f origin = pose.translation().cast<float>();
  const octomap::point3d sensor(origin.x(), origin.y(), origin.z());
  ASSERT_NO_FATAL_FAILURE(expectMap(4.0f, sensor));
  const auto voxel = voxelsIn(*voxels[0])[50];
  const octomap::point3d wall(voxel[0], voxel[1], voxel[2]);
  const auto* const before_wall = map->search(sensor + (wall - sensor) * 0.3f);
  ASSERT_NE(before_wall, nullptr);
  EXPECT_FALSE(map->isNodeOccupied(before_wall));
}

TEST_F(Maps, ServiceInsertsTheFramesSinceTheLastUpdate)
{
  ASSERT_NO_FATAL_FAILURE(
      startWithMap({{"map_rate", 0.001}, {"max_merge_age", 3600.0}}));
  EXPECT_TRUE(writeMap().response.success);
  expectMap(4.0f);
}

TEST_F(Maps, ShutdownWritesTheMap)
{
  ASSERT_NO_FATAL_FAILURE(startWithMap());
  EXPECT_FALSE(fs::exists(path));
  EXPECT_EQ(decompressor->interrupt(), 0) << decompressor->output();
  decompressor->expectOutput(path);
  expectMap(4.0f);
}

TEST_F(Maps, EmptyMapReplacesNoFile)
{
  std::ofstream(path) << "earlier map";
  startDecompressor({{"map_path", path}});
  EXPECT_EQ(decompressor->interrupt(), 0) << decompressor->output();
  std::ifstream file(path);
  std::string kept;
  std::getline(file, kept);
  EXPECT_EQ(kept, "earlier map");
}

TEST_F(Maps, FileThatCannotBeWrittenIsReported)
{
  const std::string folder = temporaryFolder() + space;
  ASSERT_TRUE(fs::create_directory(folder));
  ASSERT_NO_FATAL_FAILURE(startWithMap({{"map_path", folder + "/map.ot"}}));
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
  startDecompressor();
  const std_srvs::Trigger call = writeMap();
  EXPECT_FALSE(call.response.success);
  EXPECT_NE(call.response.message.find("map_path"), std::string::npos)
      << call.response.message;
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros1
