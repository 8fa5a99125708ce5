/** \file
 * \brief Messages that are invalid or of other formats.
 */
#include "stream_scenario.h"

#include <std_msgs/String.h>

#include <algorithm>
#include <functional>
#include <random>

namespace pcl_ext_ros {
namespace test {

namespace {

class Garbage : public StreamScenario {
protected:
  Garbage() : second_sender(node.advertise<CompressedPointCloud2>(compressed, 1000)) {}

  void
  startWithSecondSender()
  {
    startBoth();
    ASSERT_TRUE(waitForSubscribers(second_sender, 2));
  }

  /** \brief Publishes a frame and waits for it, as the frames of the compressor come over
   * another connection. */
  void
  inject(const CompressedPointCloud2& frame)
  {
    const std::size_t before = frames.count();
    second_sender.publish(frame);
    EXPECT_TRUE(frames.waitForCount(before + 1));
  }

  void
  expectThatTheStreamContinues()
  {
    const std::size_t before = voxels.count();
    // After a broken frame the decompressor may need an I-frame.
    EXPECT_TRUE(waitFor([&] {
      clouds.publish(cloud(next++));
      return voxels.waitForCount(before + 1, 0.5);
    })) << decompressor->output();
    expectNextCloud();
    EXPECT_TRUE(compressor->isRunning());
    EXPECT_TRUE(decompressor->isRunning());
  }

  void
  expectNextCloud()
  {
    expectClouds(next, next + 1);
    ++next;
  }

  CompressedPointCloud2
  goodFrame()
  {
    const auto frame = compress(cloud(next++));
    EXPECT_TRUE(frame);
    return frame ? *frame : CompressedPointCloud2();
  }

  ros::Publisher second_sender;
  std::uint32_t next = 0; // number of the next cloud
};

TEST_F(Garbage, RandomBytesAsFrames)
{
  startWithSecondSender();
  expectThatTheStreamContinues();
  std::mt19937 random(2);
  CompressedPointCloud2 frame = goodFrame();
  ASSERT_TRUE(voxels.waitForCount(frames.count()));
  const std::size_t shown = voxels.count();
  for (int i = 0; i < 100; ++i) {
    frame.compressed_data.resize(random() % 5000);
    for (std::uint8_t& byte : frame.compressed_data)
      byte = static_cast<std::uint8_t>(random());
    inject(frame);
  }
  decompressor_health.expectValue("frames failed", 100);
  EXPECT_EQ(voxels.count(), shown);
  decompressor_health.expectLevel(DiagnosticStatus::WARN);
  expectThatTheStreamContinues();
}

TEST_F(Garbage, FramesThatAreCutOrChanged)
{
  startWithSecondSender();
  std::mt19937 random(3);
  for (int i = 0; i < 30; ++i) {
    CompressedPointCloud2 frame = goodFrame();
    auto& bytes = frame.compressed_data;
    if (i % 2 == 0)
      bytes.resize(random() % bytes.size());
    else
      bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1 + random() % 255);
    inject(frame);
  }
  expectThatTheStreamContinues();
}

TEST_F(Garbage, RepeatedFramesInReverseOrder)
{
  startWithSecondSender();
  std::vector<CompressedPointCloud2> sent;
  for (int i = 0; i < 6; ++i)
    sent.push_back(goodFrame());
  std::reverse(sent.begin(), sent.end());
  for (const CompressedPointCloud2& frame : sent)
    inject(frame);
  expectThatTheStreamContinues();
}

TEST_F(Garbage, OtherFormatsAndOtherGlobalFrames)
{
  startWithSecondSender();
  const CompressedPointCloud2 good = goodFrame();
  for (const char* const format : {"draco", "", "pcl_ext", "zlib; pcl_ext/version1"}) {
    CompressedPointCloud2 frame = good;
    frame.format = format;
    inject(frame);
  }
  for (const char* const frame_id : {"moon", "", "world2"}) {
    CompressedPointCloud2 frame = good;
    frame.header.frame_id = frame_id;
    inject(frame);
  }
  decompressor_health.expectValue("frames of other frame id or format", 7);
  decompressor_health.expectLevel(DiagnosticStatus::ERROR);
  EXPECT_EQ(decompressor_health.value("frames failed"), 0);
  expectThatTheStreamContinues();
}

TEST_F(Garbage, WrongLayoutInTheMessageHasNoEffect)
{
  startWithSecondSender();
  CompressedPointCloud2 frame = goodFrame();
  ASSERT_TRUE(voxels.waitForCount(1));
  const Voxels expected = voxelsIn(*voxels[0]);
  frame.width = 4000000000u;
  frame.height = 7;
  frame.point_step = 0;
  frame.row_step = 1;
  frame.fields.clear();
  frame.header.stamp = ros::Time(5, 5);
  inject(frame);
  ASSERT_TRUE(voxels.waitForCount(2));
  EXPECT_TRUE(voxelsIn(*voxels[1]) == expected);
  EXPECT_EQ(voxels[1]->header.stamp, ros::Time(5, 5));
  expectThatTheStreamContinues();
}

TEST_F(Garbage, TopicOfAnotherTypeDoesNotAffectOtherStreams)
{
  ros::Publisher texts = node.advertise<std_msgs::String>(full("texts"), 10, true);
  std_msgs::String text;
  text.data = "no frame";
  texts.publish(text);
  startBoth({}, {{"streams", listOf({compressed, texts.getTopic()})}});
  expectThatTheStreamContinues();
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
  startBoth();
  for (const Break& way : breaks) {
    sensor_msgs::PointCloud2 broken = cloud(next++);
    way.apply(broken);
    clouds.publish(broken);
    expectNextCloud();
    EXPECT_FALSE(frames.waitForStamp(broken.header.stamp, 0.0)) << way.name;
    ASSERT_TRUE(compressor->isRunning()) << way.name << '\n' << compressor->output();
  }
  EXPECT_EQ(frames.count(), breaks.size());
  compressor_health.expectValue("clouds refused", static_cast<double>(breaks.size()));
  compressor_health.expectLevel(DiagnosticStatus::ERROR);
}

TEST_F(Garbage, CloudsWithoutAFinitePointGiveFramesWithoutVoxels)
{
  startBoth();
  sensor_msgs::PointCloud2 sent = cloud(next++);
  std::fill(sent.data.begin(), sent.data.end(), std::uint8_t{0xff}); // all NaN
  expectVoxels(sent, {});
  expectThatTheStreamContinues();
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros
