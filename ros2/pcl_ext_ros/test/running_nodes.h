// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Nodes that run in this program, and what they publish.
 */
#pragma once

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <rclcpp/rclcpp.hpp>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace pcl_ext_ros::test {

/** \brief Waits for a condition, at most half a minute. */
inline bool
waitUntil(const std::function<bool()>& condition,
          std::chrono::milliseconds longest = std::chrono::seconds(30))
{
  const auto deadline = std::chrono::steady_clock::now() + longest;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline)
      return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

/** \brief Keeps the messages of a topic. */
template <typename MessageT>
class Recorder {
public:
  Recorder(rclcpp::Node& node,
           const std::string& topic,
           const rclcpp::QoS& qos = rclcpp::QoS(100))
  : subscription_(node.create_subscription<MessageT>(
        topic, qos, [this](std::unique_ptr<MessageT> message) {
          const std::lock_guard<std::mutex> lock(mutex_);
          messages_.push_back(std::move(*message));
        }))
  {}

  std::vector<MessageT>
  messages() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return messages_;
  }

  std::size_t
  count() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return messages_.size();
  }

  /** \brief Waits for the next message and returns the last one. */
  std::optional<MessageT>
  next(std::size_t known)
  {
    if (!waitUntil([&] { return count() > known; }))
      return std::nullopt;
    return messages().back();
  }

  bool
  waitForPublisher() const
  {
    return waitUntil([this] { return subscription_->get_publisher_count() != 0; });
  }

private:
  mutable std::mutex mutex_;
  std::vector<MessageT> messages_;
  typename rclcpp::Subscription<MessageT>::SharedPtr subscription_;
};

/** \brief Spins nodes in a thread until it is destroyed. The nodes are destroyed
 * after. */
class RunningNodes {
public:
  explicit RunningNodes(
      std::unique_ptr<rclcpp::Executor> executor =
          std::make_unique<rclcpp::executors::SingleThreadedExecutor>())
  : executor_(std::move(executor))
  {}

  ~RunningNodes() { stop(); }

  RunningNodes(const RunningNodes&) = delete;
  RunningNodes&
  operator=(const RunningNodes&) = delete;

  template <typename NodeT>
  std::shared_ptr<NodeT>
  add(const rclcpp::NodeOptions& options = rclcpp::NodeOptions())
  {
    const auto node = std::make_shared<NodeT>(options);
    executor_->add_node(node);
    nodes_.push_back(node);
    return node;
  }

  void
  start()
  {
    thread_ = std::thread([this] { executor_->spin(); });
  }

  /** \brief Destroys a node while the others run, as a container unloads one. */
  void
  unload(std::size_t number)
  {
    executor_->remove_node(nodes_[number]);
    nodes_.erase(nodes_.begin() + static_cast<std::ptrdiff_t>(number));
  }

  /** \brief Stops and destroys the nodes, except for those that others hold. */
  void
  stop()
  {
    if (thread_.joinable()) {
      // A cancel before the thread spins would be lost.
      waitUntil([this] { return executor_->is_spinning(); });
      executor_->cancel();
      thread_.join();
    }
    for (const auto& node : nodes_)
      executor_->remove_node(node);
    nodes_.clear();
  }

private:
  std::unique_ptr<rclcpp::Executor> executor_;
  std::vector<rclcpp::Node::SharedPtr> nodes_;
  std::thread thread_;
};

/** \brief A node of the test itself. */
class Tester : public rclcpp::Node {
public:
  explicit Tester(const rclcpp::NodeOptions& options) : rclcpp::Node("tester", options)
  {}
};

/** \brief The last status of an entry; nothing if there is none.
 * \param[in] ending of the entry's name
 */
inline std::optional<diagnostic_msgs::msg::DiagnosticStatus>
lastStatus(const Recorder<diagnostic_msgs::msg::DiagnosticArray>& diagnostics,
           const std::string& ending)
{
  std::optional<diagnostic_msgs::msg::DiagnosticStatus> last;
  for (const auto& message : diagnostics.messages())
    for (const auto& status : message.status)
      if (status.name.size() >= ending.size() &&
          status.name.compare(
              status.name.size() - ending.size(), ending.size(), ending) == 0)
        last = status;
  return last;
}

/** \brief Waits for a message of an entry of the diagnostics. */
inline bool
waitForStatus(const Recorder<diagnostic_msgs::msg::DiagnosticArray>& diagnostics,
              const std::string& ending,
              unsigned char level,
              const std::string& message)
{
  return waitUntil([&] {
    for (const auto& array : diagnostics.messages())
      for (const auto& status : array.status)
        if (status.name.find(ending) != std::string::npos && status.level == level &&
            status.message.find(message) != std::string::npos)
          return true;
    return false;
  });
}

/** \brief Calls a service of a node that runs; nothing if it does not answer. */
template <typename ServiceT>
typename ServiceT::Response::SharedPtr
call(rclcpp::Node& node, const std::string& name)
{
  const auto client = node.create_client<ServiceT>(name);
  if (!client->wait_for_service(std::chrono::seconds(30)))
    return nullptr;
  auto answer =
      client->async_send_request(std::make_shared<typename ServiceT::Request>());
  if (answer.wait_for(std::chrono::seconds(30)) != std::future_status::ready)
    return nullptr;
  return answer.get();
}

/** \brief Options as those of a command line: {"-p", "resolution:=0.1"}. */
inline rclcpp::NodeOptions
optionsOf(std::vector<std::string> arguments)
{
  arguments.insert(arguments.begin(), "--ros-args");
  return rclcpp::NodeOptions().arguments(arguments);
}

} // namespace pcl_ext_ros::test
