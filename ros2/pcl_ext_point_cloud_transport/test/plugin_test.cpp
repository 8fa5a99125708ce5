// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "plugin_test.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>

namespace pcl_ext_point_cloud_transport::test {

std::string
spaceOfThisTest()
{
  const auto* const test = ::testing::UnitTest::GetInstance()->current_test_info();
  std::string name = test->name();
  for (char& letter : name)
    if (letter == '/')
      letter = '_';
  return "/test_" + std::to_string(::getpid()) + "/" + name;
}

std::string
temporaryPath(const std::string& name)
{
  static const std::string folder = [] {
    std::string text = std::filesystem::temp_directory_path() / "plugin_test_XXXXXX";
    if (::mkdtemp(text.data()) == nullptr)
      throw std::runtime_error("no temporary folder " + text);
    static std::string to_remove;
    to_remove = text;
    std::atexit([] { std::filesystem::remove_all(to_remove); });
    return text;
  }();
  return folder + "/" + name;
}

SpunNode::SpunNode(const std::string& name,
                   const Parameters& overrides,
                   rclcpp::NodeOptions options)
: node(std::make_shared<rclcpp::Node>(
      name, spaceOfThisTest(), options.parameter_overrides(overrides)))
{
  executor_.add_node(node);
  thread_ = std::thread([this] { executor_.spin(); });
  // An executor that is cancelled before it spins would spin forever.
  waitFor([this] { return executor_.is_spinning(); });
}

SpunNode::~SpunNode()
{
  executor_.cancel();
  thread_.join();
}

rclcpp::QoS
reliable()
{
  return rclcpp::QoS(20000);
}

namespace {

/** \brief This plugin alone, and a grid that does not depend on the clouds before. */
Parameters
withDefaultsOfTests(const Parameters& overrides)
{
  Parameters parameters{
      {"points.enable_pub_plugins",
       std::vector<std::string>{"point_cloud_transport/pcl_ext"}},
      {points("crop_box"),
       std::vector<double>{
           -box_edge, -box_edge, -box_edge, box_edge, box_edge, box_edge}}};
  parameters.insert(parameters.end(), overrides.begin(), overrides.end());
  return parameters;
}

} // namespace

Sender::Sender(const Parameters& overrides,
               const std::string& name,
               const rclcpp::QoS& qos,
               rclcpp::NodeOptions options)
: spun(name, withDefaultsOfTests(overrides), options)
, publisher(point_cloud_transport::PointCloudTransport(toTransport(spun.node))
                .advertise("points", toTransport(qos)))
{}

void
Sender::expectSubscribers(std::size_t count)
{
  EXPECT_TRUE(waitFor([&] { return publisher.getNumSubscribers() == count; }))
      << publisher.getNumSubscribers();
}

Receiver::Receiver(const Parameters& overrides,
                   const std::string& name,
                   const std::string& topic,
                   const rclcpp::QoS& qos,
                   rclcpp::NodeOptions options)
: spun(name, overrides, options)
{
  const auto hints = hintsOfPlugin();
  subscriber =
      point_cloud_transport::PointCloudTransport(toTransport(spun.node))
          .subscribe(
              spaceOfThisTest() + "/" + topic,
              toTransport(qos),
              [this](const Cloud::ConstSharedPtr& cloud) { clouds.add(cloud); },
              {},
              &hints);
}

void
Receiver::expectPublishers(std::size_t count)
{
  EXPECT_TRUE(waitFor([&] { return subscriber.getNumPublishers() == count; }))
      << subscriber.getNumPublishers();
}

Diagnostics::Diagnostics(rclcpp::Node& observer, const std::string& node_name)
: prefix_(spaceOfThisTest().substr(1) + "/" + node_name + ": ")
, listener_(observer, "/diagnostics")
{}

std::vector<Diagnostics::Status>
Diagnostics::entries() const
{
  std::vector<Status> found;
  for (const auto& message : listener_.recorder.messages())
    for (const Status& status : message->status)
      if (status.name.compare(0, prefix_.size(), prefix_) == 0)
        found.push_back(status);
  return found;
}

bool
Diagnostics::waitForEntry(const std::function<bool(const Status&)>& condition) const
{
  return waitFor([&] {
    for (const Status& status : entries())
      if (condition(status))
        return true;
    return false;
  });
}

double
valueOf(const Diagnostics::Status& status, const std::string& key)
{
  for (const auto& pair : status.values)
    if (pair.key == key)
      return std::stod(pair.value);
  return -1.0;
}

void
expectVoxels(Sender& sender,
             const Receiver& receiver,
             const Cloud& cloud,
             const Voxels& expected)
{
  sender.publisher.publish(cloud);
  const auto decoded = receiver.clouds.waitForStamp(cloud.header.stamp);
  ASSERT_TRUE(decoded) << "no cloud " << cloud.header.stamp.nanosec;
  EXPECT_EQ(decoded->header, cloud.header);
  EXPECT_FALSE(expected.empty());
  EXPECT_TRUE(voxelsIn(*decoded) == expected) << cloud.header.stamp.nanosec;
}

bool
isIFrame(const Compressed& frame)
{
  pcl_ext::io::VoxelFrame voxels;
  return pcl_ext::io::FrameDecoder()
      .decode(frame.compressed_data.data(), frame.compressed_data.size(), voxels)
      .ok();
}

} // namespace pcl_ext_point_cloud_transport::test

int
main(int argc, char** argv)
{
  ::testing::InitGoogleTest(&argc, argv);
  rclcpp::init(argc, argv);
  const int result = RUN_ALL_TESTS();
  rclcpp::shutdown();
  return result;
}
