/** \file
 * \brief The node that sends the clouds of the simulated robot cell.
 */
#include "simulator/robot_cell.h"
#include "stream_scenario.h"

#include <pcl_conversions/pcl_conversions.h>

#include <utility>

namespace pcl_ext_ros1 {
namespace test {

namespace {

using Clouds = Recorder<sensor_msgs::PointCloud2>;

constexpr std::uint32_t seed = 5;

class SimulatedCells : public StreamScenario {
protected:
  void
  startCell(const Parameters& parameters)
  {
    cell_node.emplace("simulated_cell",
                      full("cell"),
                      Parameters{{"seed", static_cast<int>(seed)}} + parameters);
  }

  /** \brief The points of a cloud of the cell, as bytes of a message. */
  std::vector<std::uint8_t>
  captured(unsigned int sensor, std::uint32_t frame)
  {
    pcl_ext::cell::CellFrame captured_frame;
    cell.capture(sensor, frame, captured_frame);
    sensor_msgs::PointCloud2 message;
    pcl::toROSMsg(captured_frame.cloud, message);
    return message.data;
  }

  pcl_ext::cell::RobotCell cell{seed};
  std::optional<NodeProcess> cell_node;
};

TEST_F(SimulatedCells, SendsTheCellsCloudsInTheirOrder)
{
  const Clouds first(full("kinect_1/points"));
  const Clouds fourth(full("kinect_4/points"));
  startCell({{"sensors", listOf({1, 4})},
             {"frames", 4},
             {"rate", 5},
             {"wait_for_subscribers", true}});
  for (const auto& [sensor, clouds_of_sensor] :
       {std::pair(1u, &first), {4u, &fourth}}) {
    ASSERT_TRUE(clouds_of_sensor->waitForCount(4)) << cell_node->output();
    for (std::uint32_t i = 0; i < 4; ++i) {
      const auto message = (*clouds_of_sensor)[i];
      EXPECT_TRUE(message->data == captured(sensor, i)) << sensor << ' ' << i;
      EXPECT_EQ(message->header.frame_id, "kinect_" + std::to_string(sensor));
      EXPECT_EQ(message->width, 512u);
      EXPECT_EQ(message->height, 424u);
    }
  }
  for (std::uint32_t i = 0; i < 4; ++i)
    EXPECT_EQ(first[i]->header.stamp, fourth[i]->header.stamp);
  EXPECT_TRUE(cell_node->isRunning()); // as later nodes need its transforms
}

TEST_F(SimulatedCells, CapturedFramesAreRepeated)
{
  const Clouds second(full("kinect_2/points"));
  startCell({{"sensors", listOf({2})},
             {"captured_frames", 2},
             {"rate", 20},
             {"wait_for_subscribers", true}});
  ASSERT_TRUE(second.waitForCount(5)) << cell_node->output();
  for (std::uint32_t i = 0; i < 5; ++i)
    EXPECT_TRUE(second[i]->data == captured(2, i % 2)) << i;
}

TEST_F(SimulatedCells, VoxelsOfItsCloudsAreTheLibrarys)
{
  const Clouds raw(full("kinect_3/points"));
  const Clouds shown(full("kinect_3/points/pcl_ext/voxels"));
  NodeProcess cell_compressor("intensity_compressor",
                              full("cell_compressor"),
                              compressorParameters(),
                              {"input:=kinect_3/points"});
  NodeProcess cell_decompressor(
      "intensity_decompressor",
      full("cell_decompressor"),
      {{"streams", listOf({full("kinect_3/points/pcl_ext")})}});
  startCell({{"sensors", listOf({3})}, {"rate", 5}});
  ASSERT_TRUE(shown.waitForCount(4)) << cell_decompressor.output();
  cell_node->interrupt();
  const pcl_ext::WorldPose cell_pose =
      throughMessage(pcl_ext::WorldPose(cell.sensorPose(3)));
  ASSERT_TRUE(raw.waitForCount(1));
  const ros::Time first = raw[0]->header.stamp;
  unsigned int compared = 0;
  for (const auto& message : shown.messages()) {
    // Clouds that the compressor got before the test was connected, too.
    if (message->header.stamp < first)
      continue;
    const auto cloud_of_it = raw.waitForStamp(message->header.stamp);
    ASSERT_TRUE(cloud_of_it);
    EXPECT_GT(message->width, 1000u);
    EXPECT_TRUE(voxelsIn(*message) == direct.voxelsOf(*cloud_of_it, cell_pose));
    ++compared;
  }
  EXPECT_GT(compared, 0u);
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros1
