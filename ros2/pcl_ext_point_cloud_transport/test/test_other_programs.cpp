// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The plugin in point_cloud_transport's own program, and the classes it
 * declares.
 */
#include "child_process.h"
#include "plugin_test.h"

#include <algorithm>

namespace pcl_ext_point_cloud_transport::test {

namespace {

/** \brief The program republish. */
std::vector<std::string>
republish(const std::string& name,
          const std::string& in_transport,
          const std::string& out_transport,
          const std::vector<std::string>& remappings)
{
  std::vector<std::string> command{PCL_EXT_REPUBLISH,
                                   "--ros-args",
                                   "-r",
                                   "__ns:=" + spaceOfThisTest(),
                                   "-r",
                                   "__node:=" + name,
                                   "-p",
                                   "in_transport:=" + in_transport,
                                   "-p",
                                   "out_transport:=" + out_transport};
  for (const std::string& remapping : remappings) {
    command.push_back("-r");
    command.push_back(remapping);
  }
  return command;
}

TEST(OtherPrograms, RepublishCompressesAndDecompresses)
{
  ChildProcess compressing(republish(
      "compressing", "raw", "pcl_ext", {"in:=clouds", "out/pcl_ext:=frames/pcl_ext"}));
  ChildProcess decompressing(
      republish("decompressing", "pcl_ext", "raw", {"in/pcl_ext:=frames/pcl_ext"}));
  SpunNode spun("test");
  Listener<Cloud> voxels(*spun.node, "out");
  Listener<Compressed> frames(*spun.node, "frames/pcl_ext");
  const auto clouds = spun.node->create_publisher<Cloud>("clouds", rclcpp::QoS(1000));
  const auto name = [](const char* topic) { return spaceOfThisTest() + "/" + topic; };
  ASSERT_TRUE(waitFor([&] {
    return clouds->get_subscription_count() == 1 &&
           spun.node->count_publishers(name("out")) == 1 &&
           spun.node->count_publishers(name("frames/pcl_ext")) == 1 &&
           spun.node->count_subscribers(name("frames/pcl_ext")) == 2;
  })) << compressing.output()
      << decompressing.output();
  // The parameters have the name that the program gave the topic, as for `ros2 param`.
  rclcpp::AsyncParametersClient parameters(spun.node, "compressing");
  ASSERT_TRUE(parameters.wait_for_service(std::chrono::seconds(60)));
  auto results =
      parameters.set_parameters({rclcpp::Parameter("out.pcl_ext.resolution", 0.05)});
  ASSERT_EQ(results.wait_for(std::chrono::seconds(60)), std::future_status::ready);
  EXPECT_TRUE(results.get().at(0).successful);
  // Until all are connected.
  std::uint32_t number = 0;
  ASSERT_TRUE(waitFor([&] {
    clouds->publish(makeCloud(number++, Layout::Xyzi));
    return voxels.recorder.waitForCount(1, 0.3);
  })) << compressing.output()
      << decompressing.output();
  for (const std::uint32_t end = number + 20; number < end; ++number) {
    clouds->publish(makeCloud(number, Layout::Xyzi));
    ASSERT_TRUE(voxels.recorder.waitForStamp(stampOf(number)));
  }
  // The grid is that of the first cloud which the program received.
  const auto all = frames.recorder.messages();
  ASSERT_FALSE(all.empty());
  std::uint32_t first = 0;
  while (first < number && all.front()->header.stamp != stampOf(first))
    ++first;
  auto settings = defaultSettings(Layout::Xyzi);
  settings.crop_box.reset();
  settings.compression.resolution = 0.05;
  DirectStream direct(settings);
  for (; first < number; ++first) {
    const Cloud cloud = makeCloud(first, Layout::Xyzi);
    const Voxels expected = direct.voxelsOf(cloud);
    const auto decoded = voxels.recorder.find(cloud.header.stamp);
    if (decoded) {
      EXPECT_EQ(decoded->header, cloud.header);
      EXPECT_TRUE(voxelsIn(*decoded) == expected) << first;
    }
  }
  EXPECT_TRUE(compressing.isRunning() && decompressing.isRunning());
}

TEST(OtherPrograms, TheClassesAreDeclaredAndLoaded)
{
  SpunNode spun("test");
  point_cloud_transport::PointCloudTransport transport(toTransport(spun.node));
  const auto declared = transport.getDeclaredTransports();
  const auto loadable = transport.getLoadableTransports();
  const std::string name = "point_cloud_transport/pcl_ext";
  EXPECT_EQ(std::count(declared.begin(), declared.end(), name), 1);
  EXPECT_EQ(loadable.count(name), 1u);
}

TEST(OtherPrograms, AllTransportsTogether)
{
  SpunNode spun("sender");
  auto publisher = point_cloud_transport::PointCloudTransport(toTransport(spun.node))
                       .advertise("points", toTransport(reliable()));
  Receiver receiver;
  Listener<Cloud> raw(receiver.node(), spaceOfThisTest() + "/points");
  ASSERT_TRUE(waitFor([&] { return publisher.getNumSubscribers() == 2; }));
  receiver.expectPublishers(1);
  publisher.publish(makeCloud(0));
  EXPECT_TRUE(raw.recorder.waitForStamp(stampOf(0)));
  EXPECT_TRUE(receiver.clouds.waitForStamp(stampOf(0)));
}

} // namespace

} // namespace pcl_ext_point_cloud_transport::test
