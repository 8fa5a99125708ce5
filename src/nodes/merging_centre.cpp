// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/nodes/impl/merging_centre.h>

#include "nodes/centre_stream.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <thread>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

class MergingCentre::Implementation {
public:
  Implementation(const MergingCentreSettings& settings,
                 FrameListener on_frame,
                 MergeListener on_merged)
  : settings_(settings)
  , settings_status_(checkSettings(settings))
  , on_merged_(std::move(on_merged))
  , schedule_(scheduleOf(settings))
  , node_(settings.node, std::move(on_frame))
  {
    if (settings_status_.ok())
      settings_status_ = node_.settingsStatus();
    if (settings_status_.ok() && settings.has_thread)
      thread_ = std::thread([this] { workUntilTheEnd(); });
  }

  ~Implementation()
  {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      is_ending_ = true;
    }
    frame_arrived_.notify_all();
    if (thread_.joinable())
      thread_.join();
  }

  const CentralNodeStatus&
  settingsStatus() const
  {
    return settings_status_;
  }

  CentralNode&
  node()
  {
    return node_;
  }

  CentralNodeStatus
  addStream(const std::string& name)
  {
    if (!settings_status_.ok())
      return settings_status_;
    const std::lock_guard<std::mutex> lock(mutex_);
    if (CentralNodeStatus status = node_.addStream(name); !status.ok())
      return status;
    CentreStream& stream = streams_[name];
    stream.setNoiseOfAll(noise_);
    stream.applyNoise(name, node_);
    return {};
  }

  CentralNodeStatus
  removeStream(const std::string& name)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    schedule_.remove(name);
    streams_.erase(name);
    return node_.removeStream(name);
  }

  void
  setNoise(const ParameterValues& values)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    noise_ = values;
    for (auto& [name, stream] : streams_) {
      stream.setNoiseOfAll(values);
      stream.applyNoise(name, node_);
    }
  }

  void
  setNoise(const std::string& name, const ParameterValues& own)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (const auto found = streams_.find(name); found != streams_.end()) {
      found->second.setOwnNoise(own);
      found->second.applyNoise(name, node_);
    }
  }

  void
  setMerging(bool is_on)
  {
    std::unique_lock<std::mutex> work_lock(work_mutex_, std::defer_lock);
    if (!is_on) {
      work_lock.lock(); // ends what is being merged
      due_.reset();
      has_more_ = false;
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    if (is_on == is_merging_)
      return;
    is_merging_ = is_on;
    for (ScheduledFrame& frame : schedule_.releaseAll())
      decode(std::move(frame));
  }

  void
  countLeftOut(const std::string& name)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (const auto found = streams_.find(name); found != streams_.end())
      found->second.countLeftOut(settings_.arrival_clock());
  }

  CentralNodeStatus
  receive(const std::string& name, std::vector<std::uint8_t> bytes, Time stamp)
  {
    if (!settings_status_.ok())
      return settings_status_;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      const auto found = streams_.find(name);
      if (found == streams_.end())
        return {CentralNodeCode::UnknownStream, "there is no stream '" + name + "'"};
      const Time now = settings_.arrival_clock();
      found->second.countArrival(now);
      if (!is_merging_)
        return decode({name, stamp, std::move(bytes)});
      if (!schedule_.add({name, stamp, std::move(bytes)}, now))
        found->second.countRepeatedStamp();
      has_new_frame_ = true;
    }
    frame_arrived_.notify_one();
    return {};
  }

  std::size_t
  stampsRepeated(const std::string& name) const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = streams_.find(name);
    return found == streams_.end() ? 0 : found->second.stampsRepeated();
  }

  void
  setSources(const std::string& name, Time time, std::vector<MergedSource> sources)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (const auto found = streams_.find(name); found != streams_.end())
      found->second.setSources(time, std::move(sources));
  }

  void
  work()
  {
    if (!settings_status_.ok())
      return;
    const std::lock_guard<std::mutex> work_lock(work_mutex_);
    mergeDue(settings_.has_thread ? std::nullopt : settings_.turn);
  }

  void
  finish(std::optional<Time> longest)
  {
    if (!settings_status_.ok())
      return;
    const std::lock_guard<std::mutex> work_lock(work_mutex_);
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      schedule_.end();
    }
    mergeDue(longest);
    const std::lock_guard<std::mutex> lock(mutex_);
    schedule_.leaveOutRest();
    has_ended_ = true;
  }

  MergeCounts
  mergeCounts() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    MergeCounts counts = schedule_.counts();
    if (has_ended_)
      counts.left_out += counts.made - made_;
    counts.made = made_; // without one whose frames are being decoded
    return counts;
  }

  std::vector<std::pair<std::string, HealthReport>>
  describeHealth(std::size_t map_nodes, const Amend& amend)
  {
    std::vector<std::pair<std::string, HealthReport>> reports;
    const std::vector<StreamHealth> health = node_.health();
    bool are_ok = true;
    for (const StreamHealth& of_stream : health) {
      HealthReport report;
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        const auto found = streams_.find(of_stream.name);
        if (found == streams_.end())
          continue;
        report = found->second.describe(
            of_stream, mergedResolution(), settings_.arrival_clock());
      }
      if (amend)
        amend(of_stream.name, report);
      are_ok &= report.level() == HealthLevel::Ok;
      reports.emplace_back(of_stream.name, std::move(report));
    }
    HealthReport together =
        describeTogether(health, are_ok, map_nodes, settings_.node.clock());
    const MergeCounts counts = mergeCounts();
    if (counts.left_out > reported_left_out_)
      together.raise(
          HealthLevel::Error,
          "This machine is too slow for the streams: merged frames are left out");
    reported_left_out_ = counts.left_out;
    together.add("merged frames", counts.made);
    together.add("merged frames left out", counts.left_out);
    reports.emplace_back("all streams", std::move(together));
    return reports;
  }

private:
  static CentralNodeStatus
  checkSettings(const MergingCentreSettings& settings)
  {
    if (std::string fault = faultOf(settings.schedule); !fault.empty())
      return {CentralNodeCode::InvalidSettings, std::move(fault)};
    if (!settings.arrival_clock)
      return {CentralNodeCode::InvalidSettings,
              "arrival_clock is empty; it must be set"};
    return {};
  }

  static MergeScheduleSettings
  scheduleOf(const MergingCentreSettings& settings)
  {
    MergeScheduleSettings schedule = settings.schedule;
    schedule.max_released = settings.node.max_waiting_frames;
    return schedule;
  }

  double
  mergedResolution() const
  {
    return settings_.reports_resolution ? settings_.node.resolution : 0.0;
  }

  /** \brief Passes a frame on. Whether it was refused, as this machine is too slow, is in
   * the health of its stream. */
  CentralNodeStatus
  decode(ScheduledFrame frame)
  {
    return node_.receive(frame.stream, std::move(frame.bytes), frame.stamp);
  }

  /** \brief Passes the frames on that are to be decoded now. */
  void
  takeStep()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    MergeSchedule::Step step = schedule_.next(settings_.arrival_clock());
    for (ScheduledFrame& frame : step.frames)
      decode(std::move(frame));
    has_more_ = step.has_more;
    if (step.merge)
      due_ = {step.oldest, *step.merge, std::move(step.other_clocks)};
  }

  /** \brief Merges what is due, see MergingCentreSettings::turn. */
  void
  mergeDue(const std::optional<Time>& longest)
  {
    const Time start = steadyTime();
    const auto left = [&] {
      return std::max(Time(0), longest.value_or(Time(0)) - (steadyTime() - start));
    };
    for (;;) {
      if (!due_ && !has_more_)
        takeStep();
      if (!due_ && !has_more_)
        return;
      if (!longest)
        node_.waitUntilDecoded();
      else if (!node_.waitUntilDecoded(left()))
        return;
      countDecoded();
      if (!due_)
        continue;
      merge(*std::exchange(due_, std::nullopt));
      if (longest && left() == Time(0))
        return;
    }
  }

  void
  countDecoded()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    schedule_.countDecoded();
    has_more_ = false;
  }

  std::vector<MergedSource>
  sourcesOf(const MergeStatus& merged)
  {
    std::vector<MergedSource> sources;
    const std::vector<StreamHealth> health = node_.health();
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const MergedStream& stream : merged.streams)
      if (const auto found = streams_.find(stream.name); found != streams_.end())
        found->second.addSources(stream, health, sources);
    return sources;
  }

  void
  merge(const StampRange& stamps)
  {
    const MergeStatus status = node_.mergeChanges(changes_, stamps);
    ++made_;
    if (!on_merged_)
      return;
    bool are_written = false;
    const std::function<const io::VoxelFrame&()> voxels =
        [&]() -> const io::VoxelFrame& {
      if (changes_.voxels.is_from_nothing)
        return changes_.voxels.came;
      if (!are_written)
        node_.mergedVoxels(merged_);
      are_written = true;
      return merged_;
    };
    on_merged_(
        {status, stamps.newest, changes_, voxels, sourcesOf(status), stamps.streams});
  }

  void
  workUntilTheEnd()
  {
    constexpr std::chrono::milliseconds patience{10}; // for what waits too long
    for (;;) {
      {
        std::unique_lock<std::mutex> lock(mutex_);
        frame_arrived_.wait_for(
            lock, patience, [this] { return has_new_frame_ || is_ending_; });
        if (is_ending_)
          return;
        has_new_frame_ = false;
        if (!is_merging_)
          continue;
      }
      try {
        work();
      }
      catch (const std::bad_alloc&) {
        // The next frames may find memory again.
      }
    }
  }

  const MergingCentreSettings settings_;
  CentralNodeStatus settings_status_;
  const MergeListener on_merged_;

  std::mutex work_mutex_; // before mutex_; guards merging
  // Keep their memory.
  MergedChanges changes_;
  io::VoxelFrame merged_;
  std::optional<StampRange> due_; // to be merged when its frames are decoded
  bool has_more_ = false;         // frames to be decoded before the next step

  std::atomic<std::size_t> made_{0}; // merged frames

  mutable std::mutex mutex_; // guards what follows
  std::condition_variable frame_arrived_;
  bool has_new_frame_ = false;
  bool is_ending_ = false;
  bool is_merging_ = false;
  bool has_ended_ = false; // see finish()
  MergeSchedule schedule_;
  ParameterValues noise_; // of all streams
  std::map<std::string, CentreStream> streams_;

  std::size_t reported_left_out_ = 0; // used by describeHealth() alone

  // Behind what its listener may use.
  CentralNode node_;
  std::thread thread_;
};

MergingCentre::MergingCentre(const MergingCentreSettings& settings,
                             FrameListener on_frame,
                             MergeListener on_merged)
: implementation_(std::make_unique<Implementation>(
      settings, std::move(on_frame), std::move(on_merged)))
{}

MergingCentre::~MergingCentre() = default;

const CentralNodeStatus&
MergingCentre::settingsStatus() const
{
  return implementation_->settingsStatus();
}

CentralNode&
MergingCentre::node()
{
  return implementation_->node();
}

CentralNodeStatus
MergingCentre::addStream(const std::string& stream)
{
  return implementation_->addStream(stream);
}

CentralNodeStatus
MergingCentre::removeStream(const std::string& stream)
{
  return implementation_->removeStream(stream);
}

void
MergingCentre::setNoise(const ParameterValues& values)
{
  implementation_->setNoise(values);
}

void
MergingCentre::setNoise(const std::string& stream, const ParameterValues& own)
{
  implementation_->setNoise(stream, own);
}

void
MergingCentre::setMerging(bool is_on)
{
  implementation_->setMerging(is_on);
}

void
MergingCentre::countLeftOut(const std::string& stream)
{
  implementation_->countLeftOut(stream);
}

CentralNodeStatus
MergingCentre::receive(const std::string& stream,
                       std::vector<std::uint8_t> bytes,
                       Time stamp)
{
  return implementation_->receive(stream, std::move(bytes), stamp);
}

std::size_t
MergingCentre::stampsRepeated(const std::string& stream) const
{
  return implementation_->stampsRepeated(stream);
}

void
MergingCentre::setSources(const std::string& stream,
                          Time time,
                          std::vector<MergedSource> sources)
{
  implementation_->setSources(stream, time, std::move(sources));
}

MergeCounts
MergingCentre::mergeCounts() const
{
  return implementation_->mergeCounts();
}

void
MergingCentre::work()
{
  implementation_->work();
}

void
MergingCentre::finish(std::optional<Time> longest)
{
  implementation_->finish(longest);
}

std::vector<std::pair<std::string, HealthReport>>
MergingCentre::describeHealth(std::size_t map_nodes, const Amend& amend)
{
  return implementation_->describeHealth(map_nodes, amend);
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
