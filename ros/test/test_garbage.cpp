/** \file
 * \brief Messages that are invalid or of other formats.
 */
#include "stream_scenario.h"

#include <std_msgs/String.h>

namespace pcl_ext_ros1 {
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

  /** \brief Publishes a frame and waits for it, as the frames of the compressor come
   * over another connection. */
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

TEST_F(Garbage, BytesThatAreNoFrameAreCountedAndTheStreamContinues)
{
  startWithSecondSender();
  expectThatTheStreamContinues();
  CompressedPointCloud2 frame = goodFrame();
  ASSERT_TRUE(voxels.waitForCount(frames.count()));
  const std::size_t shown = voxels.count();
  for (const std::size_t size : {0u, 1u, 5000u}) {
    frame.compressed_data.assign(size, 'P');
    inject(frame);
  }
  decompressor_health.expectValue("frames failed", 3);
  EXPECT_EQ(voxels.count(), shown);
  decompressor_health.expectLevel(DiagnosticStatus::WARN);
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

TEST_F(Garbage, BrokenCloudsAreRefusedAndReported)
{
  startBoth();
  std::vector<sensor_msgs::PointCloud2> broken(2, cloud(next++));
  broken[0].data.resize(broken[0].data.size() / 2);
  broken[1].width = broken[1].height = 1u << 31;
  for (sensor_msgs::PointCloud2& sent : broken) {
    sent.header.stamp = stampOf(next++);
    clouds.publish(sent);
    expectNextCloud();
    EXPECT_FALSE(frames.waitForStamp(sent.header.stamp, 0.0));
    ASSERT_TRUE(compressor->isRunning()) << compressor->output();
  }
  compressor_health.expectValue("clouds refused", 2);
  compressor_health.expectLevel(DiagnosticStatus::ERROR);
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros1
