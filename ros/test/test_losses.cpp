/** \file
 * \brief Lost frames, and nodes that join late or restart.
 */
#include <pcl_ext/compression/frame_decoder.h>

#include "stream_scenario.h"

#include <std_msgs/Empty.h>

#include <set>

namespace pcl_ext_ros1 {
namespace test {

namespace {

namespace io = pcl_ext::io;

bool
canDecode(io::FrameDecoder& decoder, const CompressedPointCloud2& frame)
{
  io::VoxelFrame decoded;
  const Bytes& bytes = frame.compressed_data;
  return decoder.decode(bytes.data(), bytes.size(), decoded).ok();
}

/** \brief Parameters of a stream with I-frames on request only. */
const Parameters on_demand{{"i_frame_rate", 1000000}};

/** \brief The test forwards the frames between the nodes, and can lose some. */
class Losses : public StreamScenario {
protected:
  Losses()
  : link(node.advertise<CompressedPointCloud2>(full("link"), 100))
  , requests_sent(node.advertise<std_msgs::Empty>(compressed + "/request_i_frame", 100))
  , shown(full("link/voxels"))
  , requests(full("link/request_i_frame"))
  {}

  void
  startOverLink()
  {
    transforms.set(sensor_frame, pose);
    startCompressor(on_demand);
    startLinkDecompressor();
  }

  void
  startLinkDecompressor()
  {
    ASSERT_TRUE(waitForSubscribers(requests_sent, 1));
    decompressor.emplace("intensity_decompressor",
                         full("decompressor"),
                         Parameters{{"streams", listOf({link.getTopic()})}});
    ASSERT_TRUE(waitForSubscribers(link, 1));
    decompressor->expectSubscribers(shown.topic(), 1);
    decompressor->expectSubscribers(requests.topic(), 1);
  }

  /** \brief Publishes a cloud, and its frame unless it is to be lost. The decompressor
   * must publish the library's voxels, or request an I-frame with every third failure.
   * \return true if there were voxels
   */
  bool
  send(std::uint32_t number, bool is_lost = false)
  {
    const auto frame = compress(cloud(number));
    EXPECT_TRUE(frame) << compressor->output();
    if (!frame || is_lost || HasFatalFailure())
      return false;
    const std::size_t requests_before = requests.count();
    link.publish(frame);
    const bool is_decoded = canDecode(decoder, *frame);
    if (is_decoded) {
      const auto message = shown.waitForStamp(stampOf(number));
      EXPECT_TRUE(message && voxelsIn(*message) == direct.voxelsOf(cloud(number), pose))
          << "cloud " << number << '\n'
          << decompressor->output();
      failures = 0;
    }
    else if (failures++ % 3 == 0) {
      EXPECT_TRUE(requests.waitForCount(requests_before + 1));
      requests_sent.publish(std_msgs::Empty());
    }
    return is_decoded;
  }

  ros::Publisher link;
  ros::Publisher requests_sent;
  Recorder<sensor_msgs::PointCloud2> shown;
  Recorder<std_msgs::Empty> requests;
  io::FrameDecoder decoder;  // receives the same frames as the decompressor
  unsigned int failures = 0; // since the last decoded frame
};

TEST_F(Losses, AfterALossTheStreamIsInSyncWithinTwoFrames)
{
  startOverLink();
  constexpr std::uint32_t times = 2;
  std::uint32_t number = 0;
  for (std::uint32_t i = 0; i < times; ++i) {
    for (std::uint32_t end = number + 3; number < end; ++number)
      EXPECT_TRUE(send(number));
    send(number++, true);
    EXPECT_FALSE(send(number++)); // requests an I-frame
    send(number++);               // the request may arrive after this cloud
    EXPECT_TRUE(send(number++));
  }
  EXPECT_TRUE(send(number++));
  EXPECT_EQ(requests.count(), times);
  decompressor_health.expectValue("frames received", number - times);
  EXPECT_EQ(decompressor_health.value("frames lost"), times);
  EXPECT_EQ(decompressor_health.value("I-frame requests"), times);
  EXPECT_EQ(decompressor_health.value("frames decoded"), shown.count());
  decompressor_health.expectLevel(DiagnosticStatus::WARN);
}

TEST_F(Losses, DecompressorFollowsACompressorThatRestarts)
{
  startBoth(on_demand);
  std::uint32_t number = 0;
  for (int i = 0; i < 3; ++i, number += 4) {
    expectClouds(number, number + 4);
    compressor->kill();
    ASSERT_TRUE(waitForSubscribers(clouds, 0));
    startCompressor(on_demand);
    compressor->expectSubscribers(compressed, 2);
  }
  expectClouds(number, number + 1);
  EXPECT_TRUE(decompressor->isRunning());
}

TEST_F(Losses, DecompressorThatRestartsGetsAnIFrameAsNewSubscriber)
{
  startBoth(on_demand);
  expectClouds(0, 1);
  decompressor->kill();
  ASSERT_TRUE(waitFor([this] { return compressor->subscribersOf(compressed) == 1; }));
  for (std::uint32_t i = 1; i < 4; ++i)
    ASSERT_TRUE(compress(cloud(i)));
  startDecompressor();
  // The compressor may receive the first cloud before it is notified of the subscriber.
  clouds.publish(cloud(4));
  expectClouds(5, 7);
}

TEST_F(Losses, CloudsFasterThanTheNodesLoseNoSync)
{
  startBoth(on_demand);
  constexpr std::uint32_t count = 150;
  std::vector<sensor_msgs::PointCloud2> all;
  for (std::uint32_t i = 0; i < count; ++i)
    all.push_back(cloud(i));
  for (const auto& one : all)
    clouds.publish(one);
  // Full queues drop the oldest messages, so that the last one arrives.
  EXPECT_TRUE(voxels.waitForStamp(stampOf(count - 1))) << decompressor->output();
  std::set<std::uint64_t> stamps;
  for (const auto& message : voxels.messages()) {
    stamps.insert(message->header.stamp.toNSec());
    for (std::uint32_t i = 0; i < count; ++i)
      if (message->header.stamp == stampOf(i)) {
        EXPECT_TRUE(voxelsIn(*message) == direct.voxelsOf(all[i], pose)) << i;
      }
  }
  EXPECT_EQ(stamps.size(), voxels.count());
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros1
