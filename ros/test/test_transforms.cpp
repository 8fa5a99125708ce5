/** \file
 * \brief Transforms that are missing, late, old, or change.
 */
#include "stream_scenario.h"

#include <tf2/buffer_core.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_msgs/TFMessage.h>

namespace pcl_ext_ros1 {
namespace test {

namespace {

/** \brief Parameters of a compressor that does not wait for transforms. */
const Parameters without_timeout{{"tf_timeout", 0.0}, {"queue_size", 100}};

class Transforms : public StreamScenario {
protected:
  Transforms() : moving(node.advertise<tf2_msgs::TFMessage>("/tf", 100)) {}

  /** \brief Sends the pose of a moving sensor to the compressor and to `known`. */
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

  /** \brief Starts nodes for a sensor that moves. */
  void
  startMoving(const Parameters& changes = {})
  {
    startCompressor(changes);
    startDecompressor();
    ASSERT_TRUE(waitForSubscribers(moving, 1));
  }

  /** \brief Publishes clouds until one becomes a frame, as the test cannot observe when
   * the compressor receives a transform.
   * \return number of the first cloud that became a frame
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
    ADD_FAILURE() << "no frame of these clouds\n" << compressor->output();
    return number;
  }

  ros::Publisher moving;
  tf2::BufferCore known;
};

TEST_F(Transforms, CloudsAreDroppedUntilThereIsATransform)
{
  startCompressor(without_timeout);
  startDecompressor();
  constexpr std::uint32_t without = 7;
  for (std::uint32_t i = 0; i < without; ++i)
    clouds.publish(cloud(i));
  compressor_health.expectValue("clouds without transform", without);
  EXPECT_EQ(compressor_health.value("clouds"), without);
  EXPECT_EQ(compressor_health.value("frames"), 0);
  EXPECT_EQ(frames.count(), 0u);
  compressor_health.expectLevel(DiagnosticStatus::ERROR);
  compressor->expectOutput("no transform");
  transforms.set(sensor_frame, pose);
  // The earlier clouds were dropped, not stored.
  const std::uint32_t first = sendUntilCompressed(without);
  EXPECT_GE(first, without);
  ASSERT_TRUE(frames.last());
  EXPECT_EQ(frames[0]->header.stamp, stampOf(first));
  expectClouds(1000, 1004);
}

TEST_F(Transforms, CloudWaitsForALateTransform)
{
  ASSERT_NO_FATAL_FAILURE(startMoving());
  clouds.publish(cloud(0));
  EXPECT_FALSE(frames.waitForCount(1, 0.3));
  sendMoving(samplePose(0.25), stampOf(0));
  ASSERT_TRUE(voxels.waitForCount(1)) << compressor->output();
  EXPECT_TRUE(voxelsIn(*voxels[0]) == direct.voxelsOf(cloud(0), samplePose(0.25)));
}

TEST_F(Transforms, MovingSensorHasThePoseOfEachStamp)
{
  ASSERT_NO_FATAL_FAILURE(startMoving());
  constexpr std::uint32_t count = 12;
  for (std::uint32_t i = 0; i <= count; i += 3)
    sendMoving(samplePose(0.1 * i), stampOf(i));
  Voxels before;
  for (std::uint32_t i = 0; i < count; ++i) { // two of three are interpolated
    const Voxels expected = direct.voxelsOf(cloud(i), knownPose(stampOf(i)));
    EXPECT_FALSE(expected == before);
    expectVoxels(cloud(i), expected);
    before = expected;
  }
}

TEST_F(Transforms, LatestTransformIsUsedWhereThereIsNoneAtTheStamp)
{
  ASSERT_NO_FATAL_FAILURE(startMoving({{"tf_timeout", 0.5}}));
  sendMoving(samplePose(0.0), stampOf(0));
  sendMoving(samplePose(0.3), stampOf(1));
  EXPECT_EQ(sendUntilCompressed(0), 0u);
  expectVoxels(cloud(500), direct.voxelsOf(cloud(500), knownPose(stampOf(1))));
  compressor_health.expectValue("frames with last transform", 1);
  compressor_health.expectLevel(DiagnosticStatus::WARN);
  EXPECT_EQ(compressor_health.value("clouds without transform"), 0);
}

TEST_F(Transforms, CloudOfAnUnknownFrameDoesNotGetTheTransformOfTheLastFrame)
{
  startBoth(without_timeout);
  const std::uint32_t dropped = sendUntilCompressed(0);
  const std::size_t frames_before = frames.count();
  clouds.publish(makeCloud<pcl::PointXYZ>(900, "unknown_frame"));
  expectClouds(901, 902);
  EXPECT_EQ(frames.count(), frames_before + 1);
  compressor_health.expectValue("clouds without transform", dropped + 1);
}

TEST_F(Transforms, ChangedMountingIsUsedFromThenOn)
{
  startBoth();
  expectClouds(0, 1);
  const pcl_ext::WorldPose other = samplePose(0.5);
  transforms.set(sensor_frame, other);
  // The old transform holds until the compressor receives the new one.
  std::uint32_t number = 1;
  EXPECT_TRUE(waitFor([&] {
    const auto sent = cloud(number++);
    const auto shown = show(sent);
    return shown && voxelsIn(*shown) == direct.voxelsOf(sent, other);
  }));
  for (std::uint32_t i = 2000; i < 2003; ++i)
    expectVoxels(cloud(i), direct.voxelsOf(cloud(i), other));
}

TEST_F(Transforms, FramesOfAnotherGlobalFrameAreDropped)
{
  startBoth();
  NodeProcess elsewhere("intensity_decompressor",
                        full("elsewhere"),
                        {{"streams", listOf({compressed})}, {"global_frame", "moon"}});
  const Diagnostics of_elsewhere(full("elsewhere"));
  compressor->expectSubscribers(compressed, 3);
  ASSERT_TRUE(show(cloud(0)));
  of_elsewhere.expectValue("frames of other frame id or format", 1);
  EXPECT_EQ(of_elsewhere.value("frames decoded"), 0);
  elsewhere.expectOutput("'world', not 'moon'");
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros1
