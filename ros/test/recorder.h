/** \file
 * \brief What arrives on a topic.
 */
#pragma once

#include "waiting.h"

#include <boost/function.hpp>
#include <boost/shared_ptr.hpp>

#include <ros/node_handle.h>

#include <cstddef>
#include <mutex>
#include <string>
#include <vector>

namespace pcl_ext_ros {
namespace test {

/** \brief Keeps all messages of a topic from its construction on, for any thread. */
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
    const boost::function<void(const Message&)> keep = [this](const Message& message) {
      const std::lock_guard<std::mutex> lock(mutex_);
      messages_.push_back(message);
    };
    subscriber_ = ros::NodeHandle().subscribe<MessageT>(topic, queue_size, keep);
  }

  const std::string&
  topic() const
  {
    return topic_;
  }

  std::size_t
  count() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return messages_.size();
  }

  std::vector<Message>
  messages() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return messages_;
  }

  /** \brief The message of an index, which must have arrived. */
  Message
  operator[](std::size_t index) const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return messages_.at(index);
  }

  Message
  last() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return messages_.empty() ? Message() : messages_.back();
  }

  /** \brief Waits until that many messages are there. */
  bool
  waitForCount(std::size_t count, double seconds = seconds_to_wait) const
  {
    return waitFor([&] { return this->count() >= count; }, seconds);
  }

  /** \brief Waits for a message that a test likes; those before count, too. */
  template <typename ConditionT>
  Message
  waitForOne(const ConditionT& condition, double seconds = seconds_to_wait) const
  {
    Message found;
    std::size_t seen = 0;
    waitFor(
        [&] {
          const std::vector<Message> all = messages();
          for (; seen < all.size() && !found; ++seen)
            if (condition(*all[seen]))
              found = all[seen];
          return found != nullptr;
        },
        seconds);
    return found;
  }

private:
  std::string topic_;
  mutable std::mutex mutex_;
  std::vector<Message> messages_;
  ros::Subscriber subscriber_; // last: its callback uses the others
};

} // namespace test
} // namespace pcl_ext_ros
