// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Frames that `ros2 bag` records and plays.
 */
#include "child_process.h"
#include "plugin_test.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace pcl_ext_point_cloud_transport::test {

namespace {

constexpr std::uint32_t i_frame_rate = 7;
constexpr std::uint32_t frames = 40;
constexpr std::chrono::milliseconds period(50);

class Bags : public ::testing::Test {
protected:
  /** \brief Records a stream, whose clouds are published at a fixed rate as the bag has
   * the times of their arrival. */
  void
  record()
  {
    Sender sender({{points("i_frame_rate"), static_cast<int>(i_frame_rate)}});
    Receiver receiver;
    sender.expectSubscribers(1);
    receiver.expectPublishers(1);
    ChildProcess recorder({PCL_EXT_ROS2,
                           "bag",
                           "record",
                           "--storage",
                           "mcap",
                           "--disable-keyboard-controls",
                           "--output",
                           bag,
                           "--topics",
                           topic});
    // The recorder subscribes to publishers that it knows, so that it gets the first
    // frame.
    ASSERT_TRUE(waitFor([&] { return sender.publisher.getNumSubscribers() == 2; }))
        << recorder.output();
    for (std::uint32_t i = 0; i < frames; ++i) {
      sender.publisher.publish(makeCloud(i));
      ASSERT_TRUE(receiver.clouds.waitForStamp(stampOf(i)));
      std::this_thread::sleep_for(period);
    }
    EXPECT_EQ(recorder.interrupt().value_or(-1), 0) << recorder.output();
    ASSERT_TRUE(std::filesystem::exists(bag + "/metadata.yaml")) << recorder.output();
  }

  const std::string bag =
      temporaryPath(::testing::UnitTest::GetInstance()->current_test_info()->name());
  const std::string topic = spaceOfThisTest() + "/points/pcl_ext";
};

TEST_F(Bags, PlayedFromTheMiddleTheNextIFrameIsTheFirstCloud)
{
  record();
  Receiver receiver;
  Listener<Compressed> played(receiver.node(), topic);
  ChildProcess player({PCL_EXT_ROS2,
                       "bag",
                       "play",
                       bag,
                       "--disable-keyboard-controls",
                       "--delay", // until the subscriptions are known
                       "2",
                       "--start-offset",
                       "0.9"});
  EXPECT_TRUE(receiver.clouds.waitForStamp(stampOf(frames - 1))) << player.output();
  EXPECT_EQ(player.waitForExit().value_or(-1), 0) << player.output();
  const auto number_of = [](const Stamp& stamp) {
    std::uint32_t number = 0;
    while (number < frames && stampOf(number) != stamp)
      ++number;
    return number;
  };
  ASSERT_GT(played.recorder.count(), 0u);
  const std::uint32_t first =
      number_of(played.recorder.messages().front()->header.stamp);
  EXPECT_GT(first, 5u);
  const std::uint32_t next_i_frame =
      (first + i_frame_rate - 1) / i_frame_rate * i_frame_rate;
  ASSERT_LT(next_i_frame, frames);
  EXPECT_EQ(receiver.clouds.count(), frames - next_i_frame);
  for (std::uint32_t i = next_i_frame; i < frames; ++i) {
    const auto cloud = receiver.clouds.find(stampOf(i));
    ASSERT_TRUE(cloud) << i;
    EXPECT_TRUE(voxelsIn(*cloud) == directVoxels(makeCloud(i), defaultSettings())) << i;
  }
}

#ifdef PCL_EXT_PROGRAM
TEST_F(Bags, TheProgramOfTheLibraryReadsThem)
{
  record();
  ChildProcess info({PCL_EXT_PROGRAM, "info", bag});
  EXPECT_EQ(info.waitForExit().value_or(-1), 0) << info.output();
  EXPECT_NE(info.output().find(topic), std::string::npos) << info.output();
  EXPECT_NE(info.output().find(std::to_string(frames)), std::string::npos)
      << info.output();

  const std::string folder = bag + "_decoded";
  ChildProcess decode(
      {PCL_EXT_PROGRAM, "decode", bag, "--pcd", "ascii", "--output", folder});
  EXPECT_EQ(decode.waitForExit().value_or(-1), 0) << decode.output();
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".pcd")
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  ASSERT_EQ(files.size(), frames);
  for (std::uint32_t i = 0; i < frames; ++i) {
    const Voxels expected = directVoxels(makeCloud(i), defaultSettings());
    std::ifstream file(files[i]);
    std::string line;
    std::string fields;
    while (std::getline(file, line) && line.rfind("DATA", 0) != 0)
      if (line.rfind("FIELDS", 0) == 0)
        fields = line;
    // Those of the clouds that were published, which have no intensity.
    ASSERT_EQ(fields, "FIELDS x y z") << files[i];
    for (const auto& voxel : expected) {
      std::array<float, 3> point{};
      for (float& number : point)
        file >> number;
      ASSERT_TRUE(file) << files[i];
      for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(point[axis], voxel[axis], 1e-5 * (1.0 + std::abs(voxel[axis])))
            << files[i];
    }
    EXPECT_FALSE(file >> line) << "more points in " << files[i];
  }
}
#endif

} // namespace

} // namespace pcl_ext_point_cloud_transport::test
