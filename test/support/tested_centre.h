// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/nodes/impl/merging_centre.h>

#include "nodes/merged_frame_encoder.h"
#include "support/central_streams.h"
#include "support/world_voxels.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes::test {

/** \brief Stamp of the first clouds, at time 0. */
constexpr Time first_stamp = std::chrono::seconds(1000);

/** \brief Threads that decode read it, too. */
using TestTime = std::atomic<Time>;

class TestedCentre {
public:
  explicit TestedCentre(const TestTime& now,
                        bool has_thread = false,
                        Time max_wait = MergeScheduleSettings().max_wait)
  : encoder_({})
  , centre_(settingsOf(now, has_thread, max_wait), {}, [this](const auto& frame) {
    take(frame);
  })
  {
    EXPECT_TRUE(centre_.settingsStatus().ok());
    centre_.setMerging(true);
  }

  MergingCentre&
  operator*()
  {
    return centre_;
  }

  MergingCentre*
  operator->()
  {
    return &centre_;
  }

  /** \brief A merged frame, as another centre receives it. */
  struct Sent {
    Time time;
    Bytes bytes;
    std::vector<MergedSource> sources;
  };

  std::vector<Sent>
  takeSent()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(sent_, {});
  }

  std::map<Time, pcl_ext::test::WorldVoxels> merged;

private:
  static MergingCentreSettings
  settingsOf(const TestTime& now, bool has_thread, Time max_wait)
  {
    MergingCentreSettings settings;
    settings.node = centralSettings();
    settings.has_thread = has_thread;
    settings.arrival_clock = [&now] { return now.load(); };
    settings.node.clock = [&now] { return first_stamp + now.load(); };
    settings.schedule.max_wait = max_wait;
    settings.schedule.max_age = std::chrono::milliseconds(500);
    settings.node.max_merge_age = std::chrono::milliseconds(500);
    return settings;
  }

  void
  take(const MergedFrame& frame)
  {
    ASSERT_TRUE(frame.status.ok());
    const std::lock_guard<std::mutex> lock(mutex_);
    merged[frame.time] = pcl_ext::test::worldVoxels(frame.voxels());
    Sent sent{frame.time, {}, frame.sources};
    ASSERT_TRUE(
        encoder_.encode(frame.changes, frame.voxels, frame.time, "world", sent.bytes)
            .ok());
    sent_.push_back(std::move(sent));
  }

  std::mutex mutex_; // guards what it has merged
  std::vector<Sent> sent_;
  MergedFrameEncoder encoder_;
  MergingCentre centre_;
};

/** \brief The last description of a stream. */
inline HealthReport
reportOf(TestedCentre& centre, const std::string& name)
{
  for (auto& [stream, report] : centre->describeHealth(0))
    if (stream == name)
      return report;
  ADD_FAILURE() << name;
  return {};
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes::test
