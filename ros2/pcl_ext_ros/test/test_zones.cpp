// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Centres of zones and one above them, connected by the plugin of
 * point_cloud_transport.
 */
#include "clouds.h"
#include "direct_library.h"
#include "running_nodes.h"

#include <gtest/gtest.h>

#include <pcl_ext_ros/merging_centre_node.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <optional>
#include <set>

namespace pcl_ext_ros::test {

using diagnostic_msgs::msg::DiagnosticArray;
using diagnostic_msgs::msg::DiagnosticStatus;
using sensor_msgs::msg::PointCloud2;
using namespace std::chrono_literals;

namespace {

constexpr std::size_t sensors = 4;
constexpr std::chrono::milliseconds period{50};

std::string
topicOf(std::size_t sensor)
{
  return "/kinect_" + std::to_string(sensor + 1) + "/points/pcl_ext";
}

std::string
streamOf(std::size_t zone)
{
  return "/zone_" + std::to_string(zone + 1) + "/central_node/merged/pcl_ext";
}

/** \brief Points of x, y, z and intensity in an order of their own. */
std::vector<std::array<float, 4>>
sortedPoints(const PointCloud2& cloud)
{
  std::vector<std::array<float, 4>> points(cloud.data.size() / 16);
  std::memcpy(points.data(), cloud.data.data(), 16 * points.size());
  std::sort(points.begin(), points.end());
  return points;
}

/** \brief Two zones of two sensors, the centre above, and one of all four. */
class Zones : public testing::Test {
protected:
  void
  SetUp() override
  {
    add("/", "streams:=[" + streamOf(0) + "," + streamOf(1) + "]");
    for (std::size_t zone = 0; zone < 2; ++zone)
      add("/zone_" + std::to_string(zone + 1),
          "streams:=[" + topicOf(zone) + "," + topicOf(zone + 2) + "]");
    std::string all;
    for (std::size_t i = 0; i < sensors; ++i)
      all += (i == 0 ? "" : ",") + topicOf(i);
    add("/one", "streams:=[" + all + "]");
    tester_ = nodes_.add<Tester>();
    for (std::size_t i = 0; i < sensors; ++i) {
      streams_.emplace_back(pcl_ext::nodes::ParameterValues{
          {"resolution", 0.1}, {"intensity", std::string("count")}});
      frames_.push_back(tester_->create_publisher<Frame>(topicOf(i), 10));
    }
    top_.emplace(*tester_, "/central_node/merged");
    sources_.emplace(*tester_, "/central_node/merged/streams");
    one_.emplace(*tester_, "/one/central_node/merged");
    diagnostics_.emplace(*tester_, "/diagnostics");
    stamp_ = roundedDown(tester_->now(), 100ms);
    nodes_.start();
    for (const auto& publisher : frames_)
      ASSERT_TRUE(waitUntil([&] { return publisher->get_subscription_count() == 2; }));
    ASSERT_TRUE(top_->waitForPublisher() && one_->waitForPublisher());
  }

  void
  TearDown() override
  {
    nodes_.stop();
  }

  /** \brief The next cloud of each sensor: the scene moves.
   * \param[in] dead the sensor that has none; sensors: none
   */
  void
  send(std::size_t dead = sensors)
  {
    stamp_ += period;
    for (std::size_t i = 0; i < sensors; ++i)
      if (i != dead)
        frames_[i]->publish(
            streams_[i].frameOf(makeCloud(number_, "world", stamp_),
                                samplePose(0.1 * static_cast<double>(i))));
    ++number_;
    std::this_thread::sleep_for(period);
  }

  /** \brief Sends until something is true. */
  bool
  sendUntil(const std::function<bool()>& condition, std::size_t dead = sensors)
  {
    for (int i = 0; i < 400 && !condition(); ++i)
      send(dead);
    return condition();
  }

  std::optional<Recorder<PointCloud2>> top_;
  std::optional<Recorder<PointCloud2>> one_;
  std::optional<Recorder<DiagnosticArray>> sources_;
  std::optional<Recorder<DiagnosticArray>> diagnostics_;

private:
  void
  add(const std::string& name_space, const std::string& streams)
  {
    nodes_.add<MergingCentreNode>(optionsOf({"-r",
                                             "__ns:=" + name_space,
                                             "-p",
                                             streams,
                                             "-p",
                                             "resolution:=0.1",
                                             "-p",
                                             "merge_wait:=1.0"}));
  }

  std::shared_ptr<Tester> tester_;
  std::deque<DirectStream> streams_;
  std::vector<rclcpp::Publisher<Frame>::SharedPtr> frames_;
  rclcpp::Time stamp_;
  std::uint32_t number_ = 0;
  // Last member, as the callbacks of its thread use the others.
  RunningNodes nodes_{std::make_unique<rclcpp::executors::MultiThreadedExecutor>(
      rclcpp::ExecutorOptions(), 4)};
};

/** \brief Merged clouds by their stamps. */
std::map<std::int64_t, std::vector<std::array<float, 4>>>
byStamp(const Recorder<PointCloud2>& clouds)
{
  std::map<std::int64_t, std::vector<std::array<float, 4>>> result;
  for (const PointCloud2& cloud : clouds.messages())
    result[rclcpp::Time(cloud.header.stamp).nanoseconds()] = sortedPoints(cloud);
  return result;
}

} // namespace

TEST_F(Zones, AreOneCentreOnMovingScenes)
{
  // Both have merged clouds of all sensors.
  ASSERT_TRUE(sendUntil([&] {
    return top_->count() > 5 && one_->count() > 5 &&
           lastStatus(*sources_, "all streams").has_value() &&
           sources_->messages().back().status.size() == 2 + sensors + 1;
  }));
  const std::int64_t begin =
      rclcpp::Time(sources_->messages().back().header.stamp).nanoseconds();
  const std::size_t known = top_->count();
  ASSERT_TRUE(sendUntil([&] { return top_->count() > known + 12; }));
  const auto of_zones = byStamp(*top_);
  const auto of_one = byStamp(*one_);
  std::size_t compared = 0;
  std::set<std::vector<std::array<float, 4>>> scenes;
  for (const auto& [stamp, points] : of_zones) {
    const auto same = of_one.find(stamp);
    if (stamp < begin || same == of_one.end())
      continue;
    EXPECT_EQ(points, same->second) << stamp;
    scenes.insert(points);
    ++compared;
  }
  EXPECT_GE(compared, 8u);
  EXPECT_GE(scenes.size(), 5u);
}

TEST_F(Zones, TellTheCentreAboveOfADeadSensor)
{
  // The zone's own entry for what it publishes has the same ending.
  const std::string name = "central_node: " + streamOf(1);
  const auto top_is = [&](unsigned char level, const std::string& message) {
    const auto messages = diagnostics_->messages();
    for (auto array = messages.rbegin(); array != messages.rend(); ++array)
      for (const DiagnosticStatus& status : array->status)
        if (status.name == name)
          return status.level == level && status.message == message;
    return false;
  };
  ASSERT_TRUE(sendUntil([&] { return top_is(DiagnosticStatus::OK, "OK"); }));
  ASSERT_TRUE(sendUntil(
      [&] {
        return top_is(DiagnosticStatus::WARN, "Sources are missing: " + topicOf(3));
      },
      3));
  // Alive again.
  ASSERT_TRUE(sendUntil([&] { return top_is(DiagnosticStatus::OK, "OK"); }));
  bool was_missing = false;
  for (const DiagnosticArray& message : sources_->messages())
    for (const DiagnosticStatus& status : message.status)
      was_missing |= status.level == DiagnosticStatus::STALE &&
                     status.name == "central_node: " + streamOf(1) + ": " + topicOf(3);
  EXPECT_TRUE(was_missing);
}

} // namespace pcl_ext_ros::test
