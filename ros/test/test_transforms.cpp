/** \file
 * \brief Clouds whose transform is not known, not yet, no more, or changes.
 */
#include "diagnostics.h"
#include "stream_scenario.h"

#include <tf2/buffer_core.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_msgs/TFMessage.h>

namespace pcl_ext_ros {
namespace test {

namespace {

/** \brief Clouds are used as they come, without waiting for transforms. */
const Parameters impatient{{"tf_timeout", 0.0}, {"queue_size", 100}};

class Transforms : public StreamScenario {
protected:
  Transforms() : moving(node.advertise<tf2_msgs::TFMessage>("/tf", 100)) {}

  /** \brief Sends where a moving sensor was, to the compressor and to `known`. */
  void
  sendMoving(const pcl_ext::WorldPose& sensor_pose, const ros::Time& stamp)
  {
    tf2_msgs::TFMessage message;
    message.transforms.push_back(toMessage(sensor_frame, sensor_pose, stamp));
    moving.publish(message);
    known.setTransform(message.transforms.front(), "test");
  }

  pcl_ext::WorldPose
  knownPose(const ros::Time& stamp) const
  {
    return pcl_ext::WorldPose(
        tf2::transformToEigen(known.lookupTransform("world", sensor_frame, stamp)));
  }

  /** \brief Sends clouds until one becomes a frame; what TF needs to get through to the
   * compressor only it knows.
   * \return number of the first cloud that did, or of the last sent
   */
  std::uint32_t
  sendUntilCompressed(std::uint32_t number)
  {
    const std::size_t before = frames.count();
    waitFor([&] {
      clouds.publish(cloud(number++));
      return frames.waitForCount(before + 1, 0.1);
    });
    const auto frame = frames.last();
    for (std::uint32_t i = 0; frame && i < number; ++i)
      if (stampOf(i) == frame->header.stamp)
        return i;
    ADD_FAILURE() << "no frame, or one of no cloud\n" << compressor->output();
    return number;
  }

  ros::Publisher moving;
  tf2::BufferCore known;
};

TEST_F(Transforms, AbsentTransformLeavesCloudsOut)
{
  const Diagnostics diagnostics(full("compressor"));
  startCompressor(compressorParameters() + impatient);
  constexpr std::uint32_t count = 7;
  for (std::uint32_t i = 0; i < count; ++i)
    clouds.publish(cloud(i));
  EXPECT_TRUE(diagnostics.waitForValue("clouds without transform", count))
      << diagnostics.text();
  EXPECT_EQ(diagnostics.value("clouds"), count);
  EXPECT_EQ(diagnostics.value("frames"), 0);
  EXPECT_EQ(frames.count(), 0u);
  EXPECT_TRUE(diagnostics.sawLevel(diagnostic_msgs::DiagnosticStatus::ERROR));
  EXPECT_NE(compressor->output().find("no transform"), std::string::npos)
      << compressor->output();
  EXPECT_TRUE(compressor->isRunning());
}

TEST_F(Transforms, LateTransformStartsTheStream)
{
  const Diagnostics diagnostics(full("compressor"));
  startCompressor(compressorParameters() + impatient);
  startDecompressor();
  constexpr std::uint32_t without = 3;
  for (std::uint32_t i = 0; i < without; ++i)
    clouds.publish(cloud(i));
  ASSERT_TRUE(diagnostics.waitForValue("clouds without transform", without));
  transforms.set(sensor_frame, pose);
  // None of the clouds before can come out now, as they are left out, not kept.
  const std::uint32_t first = sendUntilCompressed(without);
  EXPECT_GE(first, without);
  EXPECT_EQ(frames[0]->header.stamp, stampOf(first));
  DirectStream direct(compressorSettings());
  for (std::uint32_t i = 1000; i < 1004; ++i)
    expectVoxels(cloud(i), direct.voxelsOf(cloud(i), pose));
}

TEST_F(Transforms, CloudWaitsForATransformThatIsOnItsWay)
{
  startCompressor();
  startDecompressor();
  ASSERT_TRUE(waitFor([&] { return moving.getNumSubscribers() == 1; }));
  clouds.publish(cloud(0));
  EXPECT_FALSE(frames.waitForCount(1, 0.3));
  sendMoving(samplePose(0.25), stampOf(0));
  ASSERT_TRUE(voxels.waitForCount(1)) << compressor->output();
  DirectStream direct(compressorSettings());
  EXPECT_TRUE(voxelsIn(*voxels[0]) == direct.voxelsOf(cloud(0), samplePose(0.25)));
}

TEST_F(Transforms, MovingSensorHasThePoseOfEachStamp)
{
  startCompressor();
  startDecompressor();
  ASSERT_TRUE(waitFor([&] { return moving.getNumSubscribers() == 1; }));
  constexpr std::uint32_t count = 12;
  for (std::uint32_t i = 0; i <= count; i += 3)
    sendMoving(samplePose(0.1 * i), stampOf(i));
  DirectStream direct(compressorSettings());
  Voxels before;
  for (std::uint32_t i = 0; i < count; ++i) { // two of three lie between transforms
    const Voxels expected = direct.voxelsOf(cloud(i), knownPose(stampOf(i)));
    EXPECT_FALSE(expected == before);
    expectVoxels(cloud(i), expected);
    before = expected;
  }
}

TEST_F(Transforms, LatestTransformIsUsedWhereThereIsNoneAtTheStamp)
{
  const Diagnostics diagnostics(full("compressor"));
  startCompressor(compressorParameters() + Parameters{{"tf_timeout", 0.5}});
  startDecompressor();
  ASSERT_TRUE(waitFor([&] { return moving.getNumSubscribers() == 1; }));
  sendMoving(samplePose(0.0), stampOf(0));
  sendMoving(samplePose(0.3), stampOf(1));
  EXPECT_EQ(sendUntilCompressed(0), 0u);
  DirectStream direct(compressorSettings());
  expectVoxels(cloud(500), direct.voxelsOf(cloud(500), knownPose(stampOf(1))));
  EXPECT_TRUE(diagnostics.waitForValue("frames with last transform", 1))
      << diagnostics.text();
  EXPECT_TRUE(diagnostics.sawLevel(diagnostic_msgs::DiagnosticStatus::WARN));
  EXPECT_EQ(diagnostics.value("clouds without transform"), 0);
}

TEST_F(Transforms, OtherFramesWithoutTransformAreLeftOutAndDoNotTakeThatOfTheLast)
{
  const Diagnostics diagnostics(full("compressor"));
  transforms.set(sensor_frame, pose);
  startCompressor(compressorParameters() + impatient);
  startDecompressor();
  sendUntilCompressed(0);
  const std::size_t frames_before = frames.count();
  clouds.publish(makeCloud<pcl::PointXYZ>(900, "unknown_frame"));
  DirectStream direct(compressorSettings());
  expectVoxels(cloud(901), direct.voxelsOf(cloud(901), pose));
  EXPECT_EQ(frames.count(), frames_before + 1);
  EXPECT_TRUE(diagnostics.waitForValue("clouds without transform", 1, true))
      << diagnostics.text();
}

TEST_F(Transforms, ChangedMountingIsUsedFromThenOn)
{
  startBoth();
  DirectStream direct(compressorSettings());
  expectVoxels(cloud(0), direct.voxelsOf(cloud(0), pose));
  const pcl_ext::WorldPose other = samplePose(0.5);
  transforms.set(sensor_frame, other);
  // Until the compressor has heard of it, it rightly uses the old one.
  std::uint32_t number = 1;
  EXPECT_TRUE(waitFor([&] {
    const auto sent = cloud(number++);
    const auto shown = show(sent);
    return shown && voxelsIn(*shown) == direct.voxelsOf(sent, other);
  }));
  for (std::uint32_t i = 2000; i < 2003; ++i)
    expectVoxels(cloud(i), direct.voxelsOf(cloud(i), other));
}

TEST_F(Transforms, FramesOfAnotherWorldAreLeftOut)
{
  startBoth();
  NodeProcess elsewhere("intensity_decompressor",
                        full("elsewhere"),
                        {{"streams", listOf({compressed})}, {"global_frame", "moon"}});
  const Diagnostics of_elsewhere(full("elsewhere"));
  ASSERT_TRUE(waitForSubscribers(compressor->name(), compressed, 3));
  ASSERT_TRUE(show(cloud(0)));
  EXPECT_TRUE(of_elsewhere.waitForValue("frames of other frame id or format", 1))
      << of_elsewhere.text();
  EXPECT_EQ(of_elsewhere.value("frames decoded"), 0);
  EXPECT_NE(elsewhere.output().find("world"), std::string::npos) << elsewhere.output();
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros
