// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream_load.h"

#include <pcl_ext/nodes/central_node.h>

#include "measuring/machine.h"
#include "measuring/samples.h"
#include "simulator/robot_cell.h"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>

namespace pcl_ext {
namespace experiments {

namespace {

using nodes::Time;

constexpr std::size_t ticks_to_settle = 10;

/** \brief Counts received frames between start() and stop(). */
class Tally {
public:
  explicit Tally(Time period) : period_(period) {}

  void
  start()
  {
    is_counting_ = true;
  }

  void
  stop()
  {
    is_counting_ = false;
  }

  void
  add(const nodes::ReceivedFrame& frame)
  {
    const Time latency = nodes::systemTime() - frame.stamp;
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!frame.status.ok()) {
      ++result_.lost;
      return;
    }
    if (!is_counting_)
      return;
    ++result_.frames;
    if (period_ > Time(0) && latency > period_)
      ++result_.late;
    const double milliseconds =
        std::chrono::duration<double, std::milli>(latency).count();
    latency_sum_ms_ += milliseconds;
    result_.max_latency_ms = std::max(result_.max_latency_ms, milliseconds);
  }

  LoadResult
  result() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    LoadResult result = result_;
    if (result.frames != 0)
      result.mean_latency_ms = latency_sum_ms_ / static_cast<double>(result.frames);
    return result;
  }

private:
  const Time period_;
  std::atomic<bool> is_counting_{false};
  mutable std::mutex mutex_;
  LoadResult result_;
  double latency_sum_ms_ = 0.0;
};

/** \brief Which frame of its source a stream sends. */
class Schedule {
public:
  Schedule(const std::vector<SensorStream>& sources, unsigned int i_frame_rate)
  : sources_(sources), i_frame_rate_(std::max(1u, i_frame_rate))
  {}

  /** \brief Ticks until all streams have begun. */
  std::size_t
  ticksToBegin() const
  {
    return i_frame_rate_;
  }

  /** \brief Null if the stream has not started. */
  const std::vector<std::uint8_t>*
  frame(std::size_t stream, std::size_t tick) const
  {
    const SensorStream& source = sources_[stream % sources_.size()];
    const std::size_t turn = stream / sources_.size();
    const std::size_t first_tick = stream % i_frame_rate_;
    if (tick < first_tick)
      return nullptr;
    // It starts with one of its source's I-frames.
    const std::size_t begin = source.i_frames[turn % source.i_frames.size()];
    return &source.frames[(begin + tick - first_tick) % source.frames.size()];
  }

private:
  const std::vector<SensorStream>& sources_;
  std::size_t i_frame_rate_;
};

/** \brief Sends tick after tick: one frame of every stream in each. */
class Sender {
public:
  Sender(nodes::CentralNode& node, const Schedule& schedule, const StreamLoad& load)
  : node_(node), schedule_(schedule), streams_(load.streams)
  {
    if (load.frames_per_second > 0.0)
      period_ = std::chrono::duration_cast<Time>(
          std::chrono::duration<double>(1.0 / load.frames_per_second));
    for (std::size_t i = 0; i < streams_; ++i)
      node_.addStream(streamName(i), load.min_intensity);
  }

  void
  sendTick()
  {
    for (std::size_t stream = 0; stream < streams_; ++stream) {
      const auto* const frame = schedule_.frame(stream, tick_);
      if (frame == nullptr)
        continue;
      // A frame that is sent late counts as late.
      const Time due = period_ > Time(0)
                           ? tick_start_ + period_ * static_cast<Time::rep>(stream) /
                                               static_cast<Time::rep>(streams_)
                           : nodes::systemTime();
      waitUntil(due);
      refused_ += node_.receive(streamName(stream), *frame, due).ok() ? 0 : 1;
    }
    if (period_ == Time(0))
      node_.waitUntilDecoded();
    ++tick_;
    tick_start_ += period_;
    waitUntil(tick_start_);
  }

  std::size_t
  refused() const
  {
    return refused_;
  }

private:
  /** \brief Sleeps a millisecond at least; frames that are due together are sent
   * together. */
  static void
  waitUntil(Time due)
  {
    if (due > nodes::systemTime())
      std::this_thread::sleep_for(
          std::max<Time>(due - nodes::systemTime(), std::chrono::milliseconds(1)));
  }

  static std::string
  streamName(std::size_t stream)
  {
    return "stream_" + std::to_string(stream);
  }

  nodes::CentralNode& node_;
  const Schedule& schedule_;
  const std::size_t streams_;
  Time period_{0};
  Time tick_start_ = nodes::systemTime();
  std::size_t tick_ = 0;
  std::size_t refused_ = 0;
};

} // namespace

Workload
workloadOf(const Options& options)
{
  Workload workload;
  if (options.outlier_removal) {
    workload.outlier_removal.emplace();
    workload.outlier_removal->min_log_odds = *options.outlier_removal;
  }
  workload.temporal_filter = options.temporal_filter;
  return workload;
}

std::vector<SensorStream>
encodeCell(std::size_t frames, const Workload& workload, const Variant& variant)
{
  std::vector<SensorStream> streams(cell::RobotCell::sensor_count);
  pcl::PCLPointCloud2 cloud;
  for (unsigned int sensor = 1; sensor <= streams.size(); ++sensor) {
    SensorStream& encoded = streams[sensor - 1];
    const measuring::InputStream stream = measuring::openCellStream(sensor, frames);
    const WorldPose pose(stream.clouds->sensorPose());
    nodes::SensorNode node(measuring::sensorNodeSettings(stream, workload, variant));
    for (std::size_t i = 0; i < frames; ++i) {
      stream.clouds->read(i, cloud);
      std::vector<std::uint8_t> bytes;
      if (const auto status = node.encode(cloud, pose, bytes); !status.hasFrame())
        throw std::runtime_error(status.message());
      const io::CodedFrameStatistics coding = node.statistics().frame.coding;
      if (coding.is_i_frame)
        encoded.i_frames.push_back(i);
      encoded.bytes += bytes.size();
      encoded.voxels += coding.voxels;
      encoded.frames.push_back(std::move(bytes));
    }
  }
  return streams;
}

std::size_t
ticksOf(const StreamLoad& load)
{
  return load.i_frame_rate + ticks_to_settle +
         static_cast<std::size_t>(load.seconds * load.frames_per_second) + 1;
}

LoadResult
sendStreams(const std::vector<SensorStream>& sources, const StreamLoad& load)
{
  // Freed memory that stays in the heap would not be counted when it is used again.
  malloc_trim(0);
  const double megabytes = measuring::residentMegabytes();
  const bool is_paced = load.frames_per_second > 0.0;
  Tally tally(is_paced ? std::chrono::duration_cast<Time>(std::chrono::duration<double>(
                             1.0 / load.frames_per_second))
                       : Time(0));
  nodes::CentralNodeSettings settings;
  settings.threads = load.threads;
  settings.resolution = load.resolution;
  nodes::CentralNode node(
      settings, [&tally](const nodes::ReceivedFrame& frame) { tally.add(frame); });
  const Schedule schedule(sources, load.i_frame_rate);
  Sender sender(node, schedule, load);
  for (std::size_t tick = 0; tick < schedule.ticksToBegin() + ticks_to_settle; ++tick)
    sender.sendTick();

  tally.start();
  const double cpu_before = measuring::processCpuSeconds();
  const Time start = nodes::systemTime();
  const auto seconds = [&start] {
    return std::chrono::duration<double>(nodes::systemTime() - start).count();
  };
  while (seconds() < load.seconds)
    sender.sendTick();
  const double measured = seconds();
  const double cpu = measuring::processCpuSeconds() - cpu_before;
  node.waitUntilDecoded();
  tally.stop();
  LoadResult result = tally.result();
  io::VoxelFrame merged;
  result.merge_ms = measuring::timeOf([&] { node.merge(merged); });
  result.merged_voxels = merged.size();
  result.seconds = measured;
  result.cpu_seconds = cpu;
  result.lost += sender.refused();
  result.megabytes_per_stream =
      (measuring::residentMegabytes() - megabytes) / static_cast<double>(load.streams);
  return result;
}

std::size_t
mostStreams(const std::vector<SensorStream>& sources,
            const StreamLoad& load,
            LoadResult& best)
{
  // Another program may disturb a run.
  constexpr int attempts = 3;
  const auto allInTime = [&](std::size_t streams) {
    StreamLoad trial = load;
    trial.streams = streams;
    for (int attempt = 0; attempt < attempts; ++attempt) {
      const LoadResult result = sendStreams(sources, trial);
      if (result.late == 0 && result.lost == 0) {
        best = result;
        return true;
      }
      // More than a disturbance.
      if (result.late > result.frames / 10)
        return false;
    }
    return false;
  };
  best = LoadResult();
  if (allInTime(load.streams))
    return load.streams;
  std::size_t good = 0;
  std::size_t bad = load.streams;
  while (bad - good > 1 + good / 50) {
    const std::size_t middle = (good + bad) / 2;
    (allInTime(middle) ? good : bad) = middle;
  }
  return good;
}

} // namespace experiments
} // namespace pcl_ext
