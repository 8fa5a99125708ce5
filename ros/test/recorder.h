/** \file
 * \brief Waiting for other threads and processes, and for messages on a topic.
 */
#pragma once

#include <boost/function.hpp>
#include <boost/shared_ptr.hpp>

#include <ros/node_handle.h>

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace pcl_ext_ros1 {
namespace test {

/** \brief Long, as a node can take seconds to start on a busy computer. Only a test
 * that fails waits so long. */
constexpr double seconds_to_wait = 20.0;

/** \brief Waits until a condition holds.
 * \return false if it does not hold in time
 */
template <typename ConditionT>
bool
waitFor(const ConditionT& condition, double seconds = seconds_to_wait)
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

/** \brief Waits until a publisher of the test has that many subscribers. */
inline bool
waitForSubscribers(const ros::Publisher& publisher, std::uint32_t count)
{
  return waitFor([&] { return publisher.getNumSubscribers() == count; });
}

/** \brief Stores all messages of a topic from its construction on. Thread-safe. */
template <typename MessageT>
class Recorder {
public:
  using Message = boost::shared_ptr<const MessageT>;

  /** \brief Subscribes.
   * \param[in] topic full name
   */
  explicit Recorder(const std::string& topic) : topic_(topic)
  {
    constexpr std::uint32_t queue_size = 1000;
    const boost::function<void(const Message&)> store = [this](const Message& message) {
      const std::lock_guard<std::mutex> lock(mutex_);
      messages_.push_back(message);
    };
    subscriber_ = ros::NodeHandle().subscribe<MessageT>(topic, queue_size, store);
  }

  const std::string&
  topic() const
  {
    return topic_;
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

  /** \brief The message of an index, which must have arrived. */
  Message
  operator[](std::size_t index) const
  {
    return messages().at(index);
  }

  /** \brief The last message; null if none arrived. */
  Message
  last() const
  {
    const std::vector<Message> all = messages();
    return all.empty() ? Message() : all.back();
  }

  /** \brief Waits until at least that many messages arrived. */
  bool
  waitForCount(std::size_t count, double seconds = seconds_to_wait) const
  {
    return waitFor([&] { return this->count() >= count; }, seconds);
  }

  /** \brief Waits for the message of a stamp, which may have arrived already.
   * \return null if it does not arrive in time
   */
  Message
  waitForStamp(const ros::Time& stamp, double seconds = seconds_to_wait) const
  {
    Message found;
    waitFor(
        [&] {
          for (const Message& message : messages())
            if (message->header.stamp == stamp)
              found = message;
          return found != nullptr;
        },
        seconds);
    return found;
  }

private:
  const std::string topic_;
  mutable std::mutex mutex_;
  std::vector<Message> messages_;
  ros::Subscriber subscriber_; // last, as its callback uses the others
};

} // namespace test
} // namespace pcl_ext_ros1
