// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/nodes/central_node.h>

#include "bytes/exceptions.h"
#include "nodes/merged_voxels.h"
#include "nodes/received_stream.h"
#include "stream/setting_checks.h"
#include "voxels/frame_parts.h"

#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <shared_mutex>
#include <thread>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

constexpr unsigned int most_threads = 1024;

CentralNodeStatus
checkSettings(const CentralNodeSettings& settings)
{
  const auto invalid = [](const char* name, const auto& value, const char* demand) {
    return CentralNodeStatus(CentralNodeCode::InvalidSettings,
                             io::invalidText(name, value, demand));
  };
  if (settings.threads > most_threads)
    return invalid("threads", settings.threads, "0 to 1024");
  if (settings.max_waiting_frames == 0)
    return invalid("max_waiting_frames", 0, "1 or more");
  if (settings.max_merge_age <= Time(0))
    return invalid("max_merge_age",
                   std::chrono::duration<double>(settings.max_merge_age).count(),
                   "above 0 seconds");
  if (!settings.clock)
    return invalid("clock", "empty", "set");
  io::EncoderSettings codec;
  codec.resolution = settings.resolution;
  codec.origin = settings.origin;
  codec.decoder_limits = settings.decoder_limits;
  if (const io::CompressionStatus status = io::checkSettings(codec); !status.ok())
    return {CentralNodeCode::InvalidSettings, status.text()};
  return {};
}

CentralNodeSettings
withBudget(CentralNodeSettings settings)
{
  if (!settings.decoder_limits.budget)
    settings.decoder_limits.budget = std::make_shared<io::MemoryBudget>();
  return settings;
}

unsigned int
threadsOf(const CentralNodeSettings& settings)
{
  return settings.threads != 0 ? settings.threads
                               : std::max(1u, std::thread::hardware_concurrency());
}

CentralNodeStatus
unknownStream(const std::string& name)
{
  return {CentralNodeCode::UnknownStream, "there is no stream '" + name + "'"};
}

} // namespace

class CentralNode::Implementation {
public:
  Implementation(const CentralNodeSettings& settings, FrameListener listener)
  : settings_(withBudget(settings))
  , settings_status_(checkSettings(settings))
  , listener_(std::move(listener))
  , pool_(settings_status_.ok() ? threadsOf(settings) : 1)
  , merged_voxels_(settings.resolution,
                   settings.origin,
                   settings_status_.ok() ? threadsOf(settings) : 1)
  {}

  // Joined first, as the threads use the other members.
  ~Implementation() { pool_.join(); }

  const CentralNodeStatus&
  settingsStatus() const
  {
    return settings_status_;
  }

  CentralNodeStatus
  addStream(const std::string& name, float min_intensity)
  {
    if (!settings_status_.ok())
      return settings_status_;
    if (name.empty())
      return {CentralNodeCode::InvalidSettings, "the name of a stream is empty"};
    if (CentralNodeStatus status = checkMinIntensity(min_intensity); !status.ok())
      return status;
    const std::unique_lock<std::shared_mutex> lock(streams_mutex_);
    if (streams_.count(name) != 0)
      return {CentralNodeCode::StreamExists,
              "the stream '" + name + "' exists already"};
    streams_[name] =
        std::make_shared<ReceivedStream>(name, min_intensity, settings_.decoder_limits);
    return {};
  }

  CentralNodeStatus
  removeStream(const std::string& name)
  {
    if (!settings_status_.ok())
      return settings_status_;
    const std::unique_lock<std::shared_mutex> lock(streams_mutex_);
    return streams_.erase(name) == 0 ? unknownStream(name) : CentralNodeStatus();
  }

  CentralNodeStatus
  setMinIntensity(const std::string& name, float min_intensity)
  {
    if (!settings_status_.ok())
      return settings_status_;
    if (CentralNodeStatus status = checkMinIntensity(min_intensity); !status.ok())
      return status;
    const auto stream = find(name);
    if (stream == nullptr)
      return unknownStream(name);
    stream->setMinIntensity(min_intensity);
    return {};
  }

  CentralNodeStatus
  setPacked(const std::string& name, bool is_packed)
  {
    if (!settings_status_.ok())
      return settings_status_;
    const auto stream = find(name);
    if (stream == nullptr)
      return unknownStream(name);
    stream->setPacked(is_packed);
    return {};
  }

  CentralNodeStatus
  setOutlierRemoval(const std::string& name,
                    const std::optional<VoxelOutlierRemovalSettings>& settings)
  {
    if (!settings_status_.ok())
      return settings_status_;
    if (settings)
      if (const OutlierRemovalStatus status = pcl_ext::checkSettings(*settings);
          !status.ok())
        return {CentralNodeCode::InvalidSettings,
                "outlier_removal: " + status.message()};
    const auto stream = find(name);
    if (stream == nullptr)
      return unknownStream(name);
    stream->setOutlierRemoval(settings);
    return {};
  }

  CentralNodeStatus
  receive(const std::string& name,
          std::vector<std::uint8_t> bytes,
          std::optional<Time> stamp)
  {
    try {
      return receiveOrThrow(name, std::move(bytes), stamp);
    }
    catch (const std::bad_alloc&) {
      return outOfMemoryStatus<CentralNodeStatus>();
    }
  }

  void
  waitUntilDecoded()
  {
    std::unique_lock<std::mutex> lock(waiting_mutex_);
    nothing_waits_.wait(lock, [this] { return waiting_ == 0; });
  }

  bool
  waitUntilDecoded(Time timeout)
  {
    std::unique_lock<std::mutex> lock(waiting_mutex_);
    return nothing_waits_.wait_for(lock, timeout, [this] { return waiting_ == 0; });
  }

  void
  refuseWaiting()
  {
    is_refusing_ = true;
    waitUntilDecoded();
    is_refusing_ = false;
  }

  std::optional<LatestFrame>
  latestVoxels(const std::string& name, io::VoxelFrame& voxels) const
  {
    std::optional<LatestFrame> frame;
    if (const auto stream = find(name))
      frame = stream->latestVoxels(voxels);
    if (!frame)
      voxels = io::VoxelFrame();
    return frame;
  }

  MergeStatus
  merge(io::VoxelFrame& merged, const std::optional<StampRange>& stamps)
  {
    MergeStatus status = mergeInto([&] { merged_voxels_.write(merged); }, stamps);
    if (!status.ok())
      merged = io::VoxelFrame();
    return status;
  }

  MergeStatus
  mergeChanges(MergedChanges& changes, const std::optional<StampRange>& stamps)
  {
    MergeStatus status = mergeInto([&] { listChanges(changes); }, stamps);
    if (!status.ok()) {
      changes = MergedChanges();
      changes.voxels.is_from_nothing = true;
    }
    return status;
  }

  void
  mergedVoxels(io::VoxelFrame& merged)
  {
    const std::lock_guard<std::mutex> merge_lock(merge_mutex_);
    callOrCleanUp([&] { merged_voxels_.write(merged); },
                  [&] { merged = io::VoxelFrame(); });
  }

  std::vector<StreamHealth>
  health() const
  {
    std::vector<StreamHealth> health;
    const std::shared_lock<std::shared_mutex> lock(streams_mutex_);
    for (const auto& [name, stream] : streams_)
      health.push_back(stream->health(settings_.clock()));
    return health;
  }

private:
  /** \brief Merges the streams, and gives the result out. */
  template <typename WriteT>
  MergeStatus
  mergeInto(const WriteT& write, const std::optional<StampRange>& stamps)
  {
    if (!settings_status_.ok())
      return {settings_status_.code(), settings_status_.message()};
    const auto merge_and_write = [&] {
      MergeStatus status = mergeStreams(stamps);
      write();
      return status;
    };
    try {
      const std::lock_guard<std::mutex> merge_lock(merge_mutex_);
      return callOrCleanUp(merge_and_write, [&] { merged_voxels_.releaseMemory(); });
    }
    catch (const std::bad_alloc&) {
      const CentralNodeStatus status = outOfMemoryStatus<CentralNodeStatus>();
      return {status.code(), status.message()};
    }
  }

  MergeStatus
  mergeStreams(const std::optional<StampRange>& stamps)
  {
    const Time now = settings_.clock();
    MergedVoxels::Streams streams;
    {
      const std::shared_lock<std::shared_mutex> lock(streams_mutex_);
      streams = streams_;
    }
    ++merge_number_;
    MergeStatus status;
    status.streams =
        merged_voxels_.merge(streams, {now - settings_.max_merge_age, now, stamps});
    return status;
  }

  void
  listChanges(MergedChanges& changes)
  {
    changes.number = merge_number_;
    if (merged_voxels_.listChanges(changes.voxels))
      return;
    merged_voxels_.write(changes.voxels.came);
    io::beginLike(changes.voxels.came, changes.voxels.gone);
    changes.voxels.is_from_nothing = true;
  }

  /** \brief As receive(), but throws std::bad_alloc without memory for a message. */
  CentralNodeStatus
  receiveOrThrow(const std::string& name,
                 std::vector<std::uint8_t> bytes,
                 std::optional<Time> stamp)
  {
    if (!settings_status_.ok())
      return settings_status_;
    const auto stream = find(name);
    if (stream == nullptr)
      return unknownStream(name);
    {
      const std::lock_guard<std::mutex> lock(waiting_mutex_);
      ++waiting_;
    }
    const auto admission = stream->admit(std::move(bytes),
                                         stamp,
                                         settings_.max_waiting_frames,
                                         [this, &stream] { queueTurn(stream); });
    if (admission == ReceivedStream::Admission::Waits)
      return {};
    countDone();
    if (admission == ReceivedStream::Admission::OutOfMemory)
      return outOfMemoryStatus<CentralNodeStatus>();
    return {CentralNodeCode::TooManyWaiting,
            "the frame was refused, as " +
                std::to_string(settings_.max_waiting_frames) + " frames of '" + name +
                "' are waiting"};
  }

  /** \brief Queues a turn of a stream after those of other streams. */
  void
  queueTurn(const std::shared_ptr<ReceivedStream>& stream)
  {
    boost::asio::post(pool_, [this, stream] { runTurn(stream); });
  }

  /** \brief Decodes one frame of a stream, so that all streams get the same share of
   * the threads. */
  void
  runTurn(const std::shared_ptr<ReceivedStream>& stream)
  {
    for (;;) {
      if (is_refusing_)
        stream->refuseNext();
      else
        stream->decodeNext(settings_.clock, listener_);
      countDone();
      if (!stream->endTurn())
        return;
      try {
        queueTurn(stream);
        return;
      }
      catch (const std::bad_alloc&) {
        // Without memory to queue the next turn it is run at once.
      }
    }
  }

  /** \brief Counts a frame that does not wait any more. */
  void
  countDone()
  {
    const std::lock_guard<std::mutex> lock(waiting_mutex_);
    if (--waiting_ == 0)
      nothing_waits_.notify_all();
  }

  static CentralNodeStatus
  checkMinIntensity(float min_intensity)
  {
    if (std::isnan(min_intensity))
      return {CentralNodeCode::InvalidSettings,
              "min_intensity is nan; it must be a number"};
    return {};
  }

  /** \brief The stream of a name, which may be removed meanwhile; null if there is
   * none. */
  std::shared_ptr<ReceivedStream>
  find(const std::string& name) const
  {
    const std::shared_lock<std::shared_mutex> lock(streams_mutex_);
    const auto found = streams_.find(name);
    return found == streams_.end() ? nullptr : found->second;
  }

  const CentralNodeSettings settings_;
  const CentralNodeStatus settings_status_;
  const FrameListener listener_;
  boost::asio::thread_pool
      pool_; // joined by the destructor, as its threads use the other members

  mutable std::shared_mutex streams_mutex_; // guards the map, not its streams
  std::map<std::string, std::shared_ptr<ReceivedStream>> streams_;

  std::mutex waiting_mutex_;
  std::condition_variable nothing_waits_;
  std::size_t waiting_ = 0;              // frames of all streams not yet decoded
  std::atomic<bool> is_refusing_{false}; // those that wait

  std::mutex merge_mutex_; // guards merging
  std::size_t merge_number_ = 0;
  MergedVoxels merged_voxels_;
};

CentralNode::CentralNode(const CentralNodeSettings& settings, FrameListener listener)
: implementation_(std::make_unique<Implementation>(settings, std::move(listener)))
{}

CentralNode::~CentralNode() = default;

const CentralNodeStatus&
CentralNode::settingsStatus() const
{
  return implementation_->settingsStatus();
}

CentralNodeStatus
CentralNode::addStream(const std::string& name, float min_intensity)
{
  return implementation_->addStream(name, min_intensity);
}

CentralNodeStatus
CentralNode::removeStream(const std::string& name)
{
  return implementation_->removeStream(name);
}

CentralNodeStatus
CentralNode::setMinIntensity(const std::string& name, float min_intensity)
{
  return implementation_->setMinIntensity(name, min_intensity);
}

CentralNodeStatus
CentralNode::setPacked(const std::string& name, bool is_packed)
{
  return implementation_->setPacked(name, is_packed);
}

CentralNodeStatus
CentralNode::setOutlierRemoval(
    const std::string& name, const std::optional<VoxelOutlierRemovalSettings>& settings)
{
  return implementation_->setOutlierRemoval(name, settings);
}

CentralNodeStatus
CentralNode::receive(const std::string& name,
                     std::vector<std::uint8_t> bytes,
                     std::optional<Time> stamp)
{
  return implementation_->receive(name, std::move(bytes), stamp);
}

void
CentralNode::waitUntilDecoded()
{
  implementation_->waitUntilDecoded();
}

bool
CentralNode::waitUntilDecoded(Time timeout)
{
  return implementation_->waitUntilDecoded(timeout);
}

void
CentralNode::refuseWaiting()
{
  implementation_->refuseWaiting();
}

std::optional<LatestFrame>
CentralNode::latestVoxels(const std::string& name, io::VoxelFrame& voxels) const
{
  return implementation_->latestVoxels(name, voxels);
}

MergeStatus
CentralNode::merge(io::VoxelFrame& merged, const std::optional<StampRange>& stamps)
{
  return implementation_->merge(merged, stamps);
}

MergeStatus
CentralNode::mergeChanges(MergedChanges& changes,
                          const std::optional<StampRange>& stamps)
{
  return implementation_->mergeChanges(changes, stamps);
}

void
CentralNode::mergedVoxels(io::VoxelFrame& merged) const
{
  implementation_->mergedVoxels(merged);
}

std::vector<StreamHealth>
CentralNode::health() const
{
  return implementation_->health();
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
