// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/impl/cloud_receiver.h>
#include <pcl_ext/nodes/impl/node_parameters.h>

#include <rclcpp/message_info.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace pcl_ext_point_cloud_transport {

/** \brief Identifies a publisher; all 0 where it is not known. */
using PublisherId = std::array<std::uint8_t, RMW_GID_STORAGE_SIZE>;

inline PublisherId
publisherOf(const rclcpp::MessageInfo& info)
{
  PublisherId id;
  const auto& gid = info.get_rmw_message_info().publisher_gid;
  std::copy(std::begin(gid.data), std::end(gid.data), id.begin());
  return id;
}

/** \brief The streams of a topic, one for each publisher. All members are
 * thread-safe. */
class StreamsOfPublishers {
public:
  using Receiver = pcl_ext::nodes::CloudReceiver;

  struct Stream {
    PublisherId publisher;
    std::shared_ptr<Receiver> receiver;
    std::uint64_t last_frame = 0;            ///< number among those of all streams
    pcl_ext::nodes::ReceiverHealth reported; ///< as of the last report
  };

  /** \brief The receiver of a publisher's stream, a new one for its first frame. Where
   * there are too many streams, that whose last frame is the oldest is forgotten. */
  std::shared_ptr<Receiver>
  receiverOf(const PublisherId& publisher)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto known =
        std::find_if(streams_.begin(), streams_.end(), [&](const Stream& stream) {
          return stream.publisher == publisher;
        });
    ++frames_;
    if (known != streams_.end()) {
      known->last_frame = frames_;
      return known->receiver;
    }
    forgetAllBut(most_streams - 1);
    auto receiver = std::make_shared<Receiver>();
    receiver->setNoise(noise_);
    streams_.push_back({publisher, receiver, frames_, {}});
    return receiver;
  }

  /** \brief Sets what is noise in all streams, from their next frames on. */
  void
  setNoise(const pcl_ext::nodes::NoiseSettings& noise)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    noise_ = noise;
    for (const Stream& stream : streams_)
      stream.receiver->setNoise(noise);
  }

  /** \brief Describes the streams in the order of their first frames, or that there is
   * none.
   * \param[in] publishers how many there are now: streams of others are forgotten,
   * except for the last one
   */
  std::vector<pcl_ext::nodes::HealthReport>
  describeHealth(std::size_t publishers)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    forgetAllBut(std::max<std::size_t>(publishers, 1));
    const pcl_ext::nodes::Time now = pcl_ext::nodes::steadyTime();
    if (streams_.empty())
      return {pcl_ext::nodes::describeHealth(
          pcl_ext::nodes::ReceiverHealth(), pcl_ext::nodes::ReceiverHealth(), now)};
    std::vector<pcl_ext::nodes::HealthReport> reports;
    for (Stream& stream : streams_) {
      const auto health = stream.receiver->health();
      reports.push_back(pcl_ext::nodes::describeHealth(health, stream.reported, now));
      stream.reported = health;
    }
    return reports;
  }

private:
  static constexpr std::size_t most_streams = 16;

  /** \brief Forgets the streams whose last frames are the oldest. */
  void
  forgetAllBut(std::size_t count)
  {
    while (streams_.size() > count)
      streams_.erase(std::min_element(
          streams_.begin(), streams_.end(), [](const Stream& a, const Stream& b) {
            return a.last_frame < b.last_frame;
          }));
  }

  std::mutex mutex_;
  pcl_ext::nodes::NoiseSettings noise_;
  std::uint64_t frames_ = 0; // of all streams
  std::vector<Stream> streams_;
};

} // namespace pcl_ext_point_cloud_transport
