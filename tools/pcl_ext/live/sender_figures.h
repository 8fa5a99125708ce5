// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/impl/health_metrics.h>

#include <cstddef>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::tools {

/** \brief Health of the streams that a command encodes, by their numbers in its output.
 * All members are thread-safe. */
class SenderFigures {
public:
  void
  addStream(std::size_t stream, const std::string& name)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    streams_[stream].first = name;
  }

  /** \brief A cloud of a stream was encoded, or left out. */
  void
  addCloud(std::size_t stream, const nodes::SensorNodeStatistics& statistics)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    nodes::SenderHealth& health = streams_[stream].second;
    health.node = statistics;
    ++health.clouds;
    health.last_arrival = nodes::steadyTime();
  }

  /** \brief Clouds of a stream were left out, as the machine is too slow for them. */
  void
  addMissed(std::size_t stream, std::size_t clouds)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    streams_[stream].second.clouds_missed += clouds;
  }

  void
  addRequest(std::size_t stream)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++streams_[stream].second.i_frame_requests;
  }

  /** \brief As nodes::senderMetrics() has them.
   * \param[in] prefix put before the names of the streams
   */
  std::string
  metrics(const std::string& prefix = "") const
  {
    std::vector<std::pair<std::string, nodes::SenderHealth>> senders;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      for (const auto& [number, named] : streams_)
        senders.emplace_back(prefix + named.first, named.second);
    }
    return nodes::senderMetrics(senders, nodes::steadyTime());
  }

private:
  mutable std::mutex mutex_;
  std::map<std::size_t, std::pair<std::string, nodes::SenderHealth>> streams_;
};

} // namespace pcl_ext::tools
