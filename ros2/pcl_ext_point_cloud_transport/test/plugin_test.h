// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Nodes of the tests, and what they received.
 */
#pragma once

#include "pcl_ext_point_cloud_transport/transport_interface.hpp"
#include "test_clouds.h"

#include <gtest/gtest.h>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <point_cloud_interfaces/msg/compressed_point_cloud2.hpp>
#include <point_cloud_transport/point_cloud_transport.hpp>
#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/empty.hpp>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace pcl_ext_point_cloud_transport::test {

using Compressed = point_cloud_interfaces::msg::CompressedPointCloud2;
using Parameters = std::vector<rclcpp::Parameter>;

/** \brief Long, as other processes may keep the computer busy. Only a test that fails
 * waits so long. */
constexpr double seconds_to_wait = 60.0;

/** \brief Waits until a condition holds.
 * \return false if it does not hold in time
 */
template <typename ConditionT>
bool
waitFor(ConditionT&& condition, double seconds = seconds_to_wait)
{
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  while (!condition()) {
    if (Clock::now() >= end)
      return condition();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

/** \brief A namespace of this test and process: nodes of other tests are never met. */
std::string
spaceOfThisTest();

/** \brief A file or folder of this process, which is removed at its end. */
std::string
temporaryPath(const std::string& name);

/** \brief A node in spaceOfThisTest() that is spun by a thread of its own. */
class SpunNode {
public:
  /** \param[in] name of the node
   * \param[in] overrides of parameters; their names begin with the topic's, see
   * points()
   * \param[in] options the rest
   */
  explicit SpunNode(const std::string& name,
                    const Parameters& overrides = {},
                    rclcpp::NodeOptions options = rclcpp::NodeOptions());
  ~SpunNode();
  SpunNode(const SpunNode&) = delete;
  SpunNode&
  operator=(const SpunNode&) = delete;

  const rclcpp::Node::SharedPtr node;

private:
  rclcpp::executors::SingleThreadedExecutor executor_;
  std::thread thread_;
};

/** \brief Reliable, with a queue that is longer than any test. */
rclcpp::QoS
reliable();

/** \brief Of this plugin. */
inline point_cloud_transport::TransportHints
hintsOfPlugin()
{
  return point_cloud_transport::TransportHints(std::string("pcl_ext"));
}

/** \brief The messages of a topic. Thread-safe. */
template <typename MessageT>
class Recorder {
public:
  using Message = std::shared_ptr<const MessageT>;

  void
  add(const Message& message)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    messages_.push_back(message);
  }

  std::vector<Message>
  messages() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return messages_;
  }

  std::size_t
  count() const
  {
    return messages().size();
  }

  bool
  waitForCount(std::size_t count, double seconds = seconds_to_wait) const
  {
    return waitFor([&] { return this->count() >= count; }, seconds);
  }

  /** \brief The message of a stamp; null if it did not arrive. */
  Message
  find(const Stamp& stamp) const
  {
    for (const Message& message : messages())
      if (message->header.stamp == stamp)
        return message;
    return nullptr;
  }

  /** \brief Waits for the message of a stamp.
   * \return null if it does not arrive in time
   */
  Message
  waitForStamp(const Stamp& stamp, double seconds = seconds_to_wait) const
  {
    Message found;
    waitFor([&] { return (found = find(stamp)) != nullptr; }, seconds);
    return found;
  }

private:
  mutable std::mutex mutex_;
  std::vector<Message> messages_;
};

/** \brief Full name of a parameter of the topic "points". */
inline std::string
points(const std::string& parameter)
{
  return "points.pcl_ext." + parameter;
}

/** \brief A node that publishes "points" with this plugin alone, and with a crop box,
 * so that the voxels of a cloud do not depend on the clouds before. */
class Sender {
public:
  explicit Sender(const Parameters& overrides = {},
                  const std::string& name = "sender",
                  const rclcpp::QoS& qos = reliable(),
                  rclcpp::NodeOptions options = rclcpp::NodeOptions());

  rclcpp::Node&
  node()
  {
    return *spun.node;
  }

  /** \brief Waits for a number of subscriptions. */
  void
  expectSubscribers(std::size_t count);

  SpunNode spun;
  point_cloud_transport::Publisher publisher;
};

/** \brief A node that subscribes to "points" with this plugin. */
class Receiver {
public:
  explicit Receiver(const Parameters& overrides = {},
                    const std::string& name = "receiver",
                    const std::string& topic = "points",
                    const rclcpp::QoS& qos = reliable(),
                    rclcpp::NodeOptions options = rclcpp::NodeOptions());

  rclcpp::Node&
  node()
  {
    return *spun.node;
  }

  void
  expectPublishers(std::size_t count);

  Recorder<Cloud> clouds; // first, as callbacks add to it
  SpunNode spun;
  point_cloud_transport::Subscriber subscriber;
};

/** \brief Subscribes to a topic with any message that has a header. */
template <typename MessageT>
class Listener {
public:
  Listener(rclcpp::Node& node, const std::string& topic)
  : subscription_(node.create_subscription<MessageT>(
        topic,
        rclcpp::QoS(1000),
        [this](const std::shared_ptr<const MessageT>& message) {
          recorder.add(message);
        }))
  {}

  Recorder<MessageT> recorder;

private:
  typename rclcpp::Subscription<MessageT>::SharedPtr subscription_;
};

/** \brief The last entry of a node in /diagnostics whose values and level the test
 * awaits. */
class Diagnostics {
public:
  using Status = diagnostic_msgs::msg::DiagnosticStatus;

  /** \param[in] observer where to subscribe
   * \param[in] node_name of the node in spaceOfThisTest() that reports
   */
  Diagnostics(rclcpp::Node& observer, const std::string& node_name);

  /** \brief All entries of the node until now. */
  std::vector<Status>
  entries() const;

  /** \brief Waits for an entry for which a condition holds. */
  bool
  waitForEntry(const std::function<bool(const Status&)>& condition) const;

private:
  std::string prefix_;
  Listener<diagnostic_msgs::msg::DiagnosticArray> listener_;
};

/** \brief The value of a key; -1 if there is none. */
double
valueOf(const Diagnostics::Status& status, const std::string& key);

/** \brief Publishes a cloud and expects these voxels with its header. */
void
expectVoxels(Sender& sender,
             const Receiver& receiver,
             const Cloud& cloud,
             const Voxels& expected);

/** \brief True if a decoder without history decodes the frame. */
bool
isIFrame(const Compressed& frame);

} // namespace pcl_ext_point_cloud_transport::test
