/** \file
 * \brief Messages that are broken, hostile or not meant for the nodes.
 */
#include "diagnostics.h"
#include "stream_scenario.h"

#include <std_msgs/String.h>

#include <algorithm>
#include <functional>
#include <random>

namespace pcl_ext_ros {
namespace test {

namespace {

using diagnostic_msgs::DiagnosticStatus;

class Garbage : public StreamScenario {
protected:
  Garbage() : intruder(node.advertise<CompressedPointCloud2>(compressed, 1000)) {}

  void
  startWithIntruder()
  {
    startBoth();
    ASSERT_TRUE(waitFor([this] { return intruder.getNumSubscribers() == 2; }));
  }

  /** \brief Sends a broken frame; what is good comes over another connection, so that its
   * arrival is waited for. */
  void
  intrude(const CompressedPointCloud2& frame)
  {
    const std::size_t before = frames.count();
    intruder.publish(frame);
    EXPECT_TRUE(frames.waitForCount(before + 1));
  }

  void
  expectThatAllIsWell()
  {
    const std::size_t before = voxels.count();
    // A broken frame may have taken the place of a good one.
    EXPECT_TRUE(waitFor([&] {
      clouds.publish(cloud(next++));
      return voxels.waitForCount(before + 1, 0.5);
    })) << decompressor->output();
    const auto sent = cloud(next++);
    expectVoxels(sent, direct.voxelsOf(sent, pose));
    EXPECT_TRUE(compressor->isRunning());
    EXPECT_TRUE(decompressor->isRunning());
  }

  CompressedPointCloud2
  goodFrame()
  {
    const auto frame = compress(cloud(next++));
    EXPECT_TRUE(frame);
    return frame ? *frame : CompressedPointCloud2();
  }

  ros::Publisher intruder;
  DirectStream direct{compressorSettings()};
  std::uint32_t next = 0;
};

TEST_F(Garbage, RandomBytesAsFrames)
{
  const Diagnostics diagnostics(full("decompressor"));
  startWithIntruder();
  expectThatAllIsWell();
  std::mt19937 random(2);
  CompressedPointCloud2 frame = goodFrame();
  ASSERT_TRUE(voxels.waitForCount(frames.count()));
  const std::size_t shown = voxels.count();
  for (int i = 0; i < 100; ++i) {
    frame.compressed_data.resize(random() % 5000);
    for (std::uint8_t& byte : frame.compressed_data)
      byte = static_cast<std::uint8_t>(random());
    intrude(frame);
  }
  EXPECT_TRUE(diagnostics.waitForValue("frames failed", 100)) << diagnostics.text();
  EXPECT_EQ(voxels.count(), shown);
  EXPECT_TRUE(diagnostics.sawLevel(DiagnosticStatus::WARN));
  expectThatAllIsWell();
}

TEST_F(Garbage, FramesThatAreCutOrChanged)
{
  startWithIntruder();
  std::mt19937 random(3);
  for (int i = 0; i < 30; ++i) {
    CompressedPointCloud2 frame = goodFrame();
    auto& bytes = frame.compressed_data;
    if (i % 2 == 0)
      bytes.resize(random() % bytes.size());
    else
      bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1 + random() % 255);
    intrude(frame);
  }
  expectThatAllIsWell();
}

TEST_F(Garbage, FramesThatCameAlreadyAndThoseInTheWrongOrder)
{
  startWithIntruder();
  std::vector<CompressedPointCloud2> sent;
  for (int i = 0; i < 6; ++i)
    sent.push_back(goodFrame());
  std::reverse(sent.begin(), sent.end());
  for (const CompressedPointCloud2& frame : sent)
    intrude(frame);
  expectThatAllIsWell();
}

TEST_F(Garbage, OtherFormatsAndOtherWorlds)
{
  const Diagnostics diagnostics(full("decompressor"));
  startWithIntruder();
  const CompressedPointCloud2 good = goodFrame();
  for (const char* const format : {"draco", "", "pcl_ext", "zlib; pcl_ext/version1"}) {
    CompressedPointCloud2 frame = good;
    frame.format = format;
    intrude(frame);
  }
  for (const char* const frame_id : {"moon", "", "world2"}) {
    CompressedPointCloud2 frame = good;
    frame.header.frame_id = frame_id;
    intrude(frame);
  }
  EXPECT_TRUE(diagnostics.waitForValue("frames of other frame id or format", 7))
      << diagnostics.text();
  EXPECT_TRUE(diagnostics.sawLevel(DiagnosticStatus::ERROR));
  EXPECT_EQ(diagnostics.value("frames failed"), 0);
  expectThatAllIsWell();
}

TEST_F(Garbage, WrongLayoutInTheMessageIsNotBelieved)
{
  startWithIntruder();
  CompressedPointCloud2 frame = goodFrame();
  ASSERT_TRUE(voxels.waitForCount(1));
  const Voxels expected = voxelsIn(*voxels[0]);
  frame.width = 4000000000u;
  frame.height = 7;
  frame.point_step = 0;
  frame.row_step = 1;
  frame.fields.clear();
  frame.header.stamp = ros::Time(5, 5);
  intrude(frame);
  ASSERT_TRUE(voxels.waitForCount(2));
  EXPECT_TRUE(voxelsIn(*voxels[1]) == expected);
  EXPECT_EQ(voxels[1]->header.stamp, ros::Time(5, 5));
  expectThatAllIsWell();
}

TEST_F(Garbage, OtherTypeOnATopicIsNoHarmToTheOtherStreams)
{
  ros::Publisher texts = node.advertise<std_msgs::String>(full("texts"), 10, true);
  std_msgs::String text;
  text.data = "no frame";
  texts.publish(text);
  transforms.set(sensor_frame, pose);
  startCompressor();
  startDecompressor({{"streams", listOf({compressed, texts.getTopic()})}});
  expectThatAllIsWell();
  EXPECT_EQ(texts.getNumSubscribers(), 0u);
}

/** \brief One way to break a cloud. */
struct Break {
  const char* name;
  std::function<void(sensor_msgs::PointCloud2&)> apply;
};

const std::vector<Break> breaks{
    {"no data", [](auto& cloud) { cloud.data.clear(); }},
    {"data cut", [](auto& cloud) { cloud.data.resize(cloud.data.size() / 2); }},
    {"no fields", [](auto& cloud) { cloud.fields.clear(); }},
    {"no z", [](auto& cloud) { cloud.fields[2].name = "depth"; }},
    {"field behind the point",
     [](auto& cloud) { cloud.fields[2].offset = 4000000000u; }},
    {"unknown type", [](auto& cloud) { cloud.fields[0].datatype = 77; }},
    {"point_step 0", [](auto& cloud) { cloud.point_step = 0; }},
    {"huge point_step", [](auto& cloud) { cloud.point_step = 4294967295u; }},
    {"huge width", [](auto& cloud) { cloud.width = 4294967295u; }},
    {"huge height", [](auto& cloud) { cloud.height = 4294967295u; }},
    {"huge both", [](auto& cloud) { cloud.width = cloud.height = 1u << 31; }}};

TEST_F(Garbage, BrokenCloudsAreRefused)
{
  const Diagnostics diagnostics(full("compressor"));
  startWithIntruder();
  for (const Break& way : breaks) {
    sensor_msgs::PointCloud2 broken = cloud(next++);
    way.apply(broken);
    clouds.publish(broken);
    const auto sent = cloud(next++);
    expectVoxels(sent, direct.voxelsOf(sent, pose));
    EXPECT_FALSE(frames.waitForOne(
        [&](const CompressedPointCloud2& frame) {
          return frame.header.stamp == broken.header.stamp;
        },
        0.0))
        << way.name;
    ASSERT_TRUE(compressor->isRunning()) << way.name << '\n' << compressor->output();
  }
  EXPECT_EQ(frames.count(), breaks.size());
  EXPECT_TRUE(
      diagnostics.waitForValue("clouds refused", static_cast<double>(breaks.size())))
      << diagnostics.text();
  EXPECT_TRUE(diagnostics.sawLevel(DiagnosticStatus::ERROR));
}

TEST_F(Garbage, CloudsWithoutAFinitePointGiveFramesWithoutVoxels)
{
  startWithIntruder();
  sensor_msgs::PointCloud2 sent = cloud(next++);
  std::fill(sent.data.begin(), sent.data.end(), std::uint8_t{0xff}); // all NaN
  expectVoxels(sent, {});
  expectThatAllIsWell();
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros
