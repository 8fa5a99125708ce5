/** \file
 * \brief Frames that do not arrive, nodes that come late, die and come back.
 */
#include <pcl_ext/compression/frame_decoder.h>

#include "diagnostics.h"
#include "stream_scenario.h"

#include <std_msgs/Empty.h>

#include <random>
#include <set>

namespace pcl_ext_ros {
namespace test {

namespace {

namespace io = pcl_ext::io;

bool
isIFrame(const CompressedPointCloud2& frame)
{
  io::FrameDecoder decoder;
  io::VoxelFrame decoded;
  return decoder
      .decode(frame.compressed_data.data(), frame.compressed_data.size(), decoded)
      .ok();
}

/** \brief Parameters of a stream that has no I-frame unless somebody asks for one. */
const Parameters on_demand =
    compressorParameters() + Parameters{{"i_frame_rate", 1000000}};

/** \brief The test is the link between the nodes, on which frames get lost. */
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
    ASSERT_TRUE(waitFor([this] { return requests_sent.getNumSubscribers() == 1; }));
    decompressor.emplace("intensity_decompressor",
                         full("decompressor"),
                         Parameters{{"streams", listOf({link.getTopic()})}});
    ASSERT_TRUE(waitFor([this] { return link.getNumSubscribers() == 1; }));
    ASSERT_TRUE(waitForSubscribers(decompressor->name(), shown.topic(), 1));
    ASSERT_TRUE(waitForSubscribers(decompressor->name(), requests.topic(), 1));
  }

  /** \brief Sends a cloud, and its frame over the link unless it is to be lost; the
   * decompressor must show what the library makes of it.
   * \return true if there were voxels
   */
  bool
  send(std::uint32_t number, bool is_lost = false)
  {
    const auto frame = compress(cloud(number));
    EXPECT_TRUE(frame) << compressor->output();
    if (!frame || is_lost)
      return false;
    const std::size_t requests_before = requests.count();
    link.publish(frame);
    io::VoxelFrame decoded;
    const bool is_decoded = decoder
                                .decode(frame->compressed_data.data(),
                                        frame->compressed_data.size(),
                                        decoded)
                                .ok();
    if (is_decoded) {
      expectShown(number);
      failures = 0;
    }
    else if (failures++ % 3 == 0) {
      EXPECT_TRUE(requests.waitForCount(requests_before + 1));
      requests_sent.publish(std_msgs::Empty());
    }
    return is_decoded;
  }

  void
  expectShown(std::uint32_t number)
  {
    const auto message = shown.waitForOne([&](const sensor_msgs::PointCloud2& one) {
      return one.header.stamp == stampOf(number);
    });
    ASSERT_TRUE(message) << "cloud " << number << '\n' << decompressor->output();
    EXPECT_TRUE(voxelsIn(*message) == direct.voxelsOf(cloud(number), pose))
        << "cloud " << number;
  }

  ros::Publisher link;
  ros::Publisher requests_sent;
  Recorder<sensor_msgs::PointCloud2> shown;
  Recorder<std_msgs::Empty> requests;
  io::FrameDecoder decoder; // gets what the decompressor gets
  unsigned int failures = 0;
  DirectStream direct{compressorSettings()};
};

TEST_F(Losses, LostFrameIsAskedForAndInSyncWithinTwoFrames)
{
  const Diagnostics diagnostics(full("decompressor"));
  startOverLink();
  constexpr std::uint32_t times = 5;
  std::uint32_t number = 0;
  for (std::uint32_t i = 0; i < times; ++i) {
    for (std::uint32_t end = number + 3; number < end; ++number)
      EXPECT_TRUE(send(number));
    send(number++, true);
    EXPECT_FALSE(send(number++)); // asks for an I-frame
    send(number++);               // the request may be on its way yet
    EXPECT_TRUE(send(number++));
  }
  EXPECT_TRUE(send(number++));
  EXPECT_EQ(requests.count(), times);
  EXPECT_TRUE(diagnostics.waitForValue("frames received", number - times));
  EXPECT_EQ(diagnostics.value("frames lost"), times) << diagnostics.text();
  EXPECT_EQ(diagnostics.value("I-frame requests"), times);
  EXPECT_EQ(diagnostics.value("frames decoded"), shown.count());
  EXPECT_TRUE(diagnostics.sawLevel(diagnostic_msgs::DiagnosticStatus::WARN));
}

TEST_F(Losses, RandomLossesNeverShowAWrongVoxel)
{
  const Diagnostics diagnostics(full("decompressor"));
  startOverLink();
  std::mt19937 random(1);
  constexpr std::uint32_t count = 80;
  std::uint32_t lost = 0;
  EXPECT_TRUE(send(0)); // losses before the first frame are known to nobody
  std::uint32_t number = 1;
  for (; number < count; ++number) {
    const bool is_lost = random() % 100 < 25;
    lost += is_lost;
    send(number, is_lost);
  }
  EXPECT_TRUE(waitFor([&] { return send(number++); }));
  EXPECT_LE(number, count + 5); // a request of three, and two frames
  EXPECT_TRUE(diagnostics.waitForValue("frames received", number - lost));
  EXPECT_EQ(diagnostics.value("frames lost"), lost) << diagnostics.text();
  EXPECT_EQ(diagnostics.value("frames decoded"), shown.count());
  EXPECT_EQ(diagnostics.value("frames failed"), number - lost - shown.count());
  EXPECT_GT(shown.count(), 15u);
}

TEST_F(Losses, DecompressorThatJoinsLateOverALinkIsInSyncWithinTwoFramesOfItsRequest)
{
  transforms.set(sensor_frame, pose);
  startCompressor(on_demand);
  for (std::uint32_t i = 0; i < 5; ++i)
    ASSERT_TRUE(compress(cloud(i)));
  startLinkDecompressor();
  EXPECT_FALSE(send(5));
  send(6);
  EXPECT_TRUE(send(7));
  EXPECT_TRUE(send(8));
}

TEST_F(Losses, DecompressorThatJoinsLateIsWelcomedWithAnIFrame)
{
  transforms.set(sensor_frame, pose);
  startCompressor(on_demand);
  for (std::uint32_t i = 0; i < 5; ++i)
    ASSERT_TRUE(compress(cloud(i)));
  startDecompressor();
  // The one that comes first may arrive before the news of the subscriber.
  clouds.publish(cloud(5));
  expectVoxels(cloud(6), direct.voxelsOf(cloud(6), pose));
  expectVoxels(cloud(7), direct.voxelsOf(cloud(7), pose));
}

TEST_F(Losses, RequestGivesOneIFrameWithinTwoFrames)
{
  const Diagnostics diagnostics(full("compressor"));
  transforms.set(sensor_frame, pose);
  startCompressor(on_demand);
  ASSERT_TRUE(waitFor([this] { return requests_sent.getNumSubscribers() == 1; }));
  std::uint32_t number = 0;
  for (; number < 5; ++number) {
    const auto frame = compress(cloud(number));
    ASSERT_TRUE(frame);
    EXPECT_EQ(isIFrame(*frame), number == 0);
  }
  // Many ask at once when one frame is lost on the way to many.
  for (int i = 0; i < 10; ++i)
    requests_sent.publish(std_msgs::Empty());
  ASSERT_TRUE(diagnostics.waitForValue("I-frame requests", 10));
  std::vector<bool> kinds;
  for (std::uint32_t end = number + 6; number < end; ++number) {
    const auto frame = compress(cloud(number));
    ASSERT_TRUE(frame);
    kinds.push_back(isIFrame(*frame));
  }
  EXPECT_EQ(kinds, (std::vector<bool>{true, false, false, false, false, false}));
  EXPECT_TRUE(diagnostics.waitForValue("I-frames", 2)) << diagnostics.text();
}

TEST_F(Losses, KilledCompressorStartsAgainWhereTheDecompressorKeepsRunning)
{
  startBoth(on_demand);
  std::uint32_t number = 0;
  for (int i = 0; i < 3; ++i) {
    for (std::uint32_t end = number + 4; number < end; ++number)
      expectVoxels(cloud(number), direct.voxelsOf(cloud(number), pose));
    compressor->kill();
    ASSERT_TRUE(waitFor([this] { return clouds.getNumSubscribers() == 0; }));
    startCompressor(on_demand);
    ASSERT_TRUE(waitForSubscribers(compressor->name(), compressed, 2));
  }
  expectVoxels(cloud(number), direct.voxelsOf(cloud(number), pose));
  EXPECT_TRUE(decompressor->isRunning());
}

TEST_F(Losses, KilledDecompressorStartsAgainInTheMiddleOfTheStream)
{
  startBoth(on_demand);
  expectVoxels(cloud(0), direct.voxelsOf(cloud(0), pose));
  decompressor->kill();
  ASSERT_TRUE(
      waitFor([this] { return subscribersOf(compressor->name(), compressed) == 1; }));
  for (std::uint32_t i = 1; i < 4; ++i)
    ASSERT_TRUE(compress(cloud(i)));
  startDecompressor();
  clouds.publish(cloud(4)); // see above
  expectVoxels(cloud(5), direct.voxelsOf(cloud(5), pose));
  expectVoxels(cloud(6), direct.voxelsOf(cloud(6), pose));
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
  // The last one stays in the queue, whatever falls out before it.
  EXPECT_TRUE(voxels.waitForOne([&](const sensor_msgs::PointCloud2& message) {
    return message.header.stamp == stampOf(count - 1);
  })) << decompressor->output();
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
} // namespace pcl_ext_ros
