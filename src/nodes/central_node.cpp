#include <pcl_ext/compression/symbol_intensities.h>
#include <pcl_ext/compression/voxel_centres.h>
#include <pcl_ext/compression/voxelizer.h>
#include <pcl_ext/nodes/central_node.h>

#include "received_stream.h"

#include <boost/asio/post.hpp>
#include <boost/asio/strand.hpp>
#include <boost/asio/thread_pool.hpp>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <sstream>
#include <thread>
#include <utility>

namespace pcl_ext {
namespace nodes {

namespace {

constexpr unsigned int most_threads = 1024;

CentralNodeStatus
checkSettings(const CentralNodeSettings& settings)
{
  const auto invalid = [](const char* name, const auto& value, const char* demand) {
    std::ostringstream message;
    message << name << " is " << value << "; it must be " << demand;
    return CentralNodeStatus(CentralNodeCode::InvalidSettings, message.str());
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
    return invalid("clock", "empty", "there to tell the time");
  io::IntensityCompressionSettings codec;
  codec.resolution = settings.resolution;
  codec.decoder_limits = settings.decoder_limits;
  if (const io::CompressionStatus status = io::checkSettings(codec); !status.ok())
    return {CentralNodeCode::InvalidSettings, status.message()};
  return {};
}

unsigned int
threadsOf(const CentralNodeSettings& settings)
{
  return settings.threads != 0 ? settings.threads
                               : std::max(1u, std::thread::hardware_concurrency());
}

io::Voxelizer
mergingVoxelizer(double resolution)
{
  io::IntensityCompressionSettings settings;
  settings.resolution = resolution;
  settings.aggregation = io::Aggregation::Sum;
  return {settings, IntensityUnit::Native};
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
  : settings_(settings)
  , settings_status_(checkSettings(settings))
  , listener_(std::move(listener))
  , pool_(settings_status_.ok() ? threadsOf(settings) : 1)
  , merging_voxelizer_(
        mergingVoxelizer(settings_status_.ok() ? settings.resolution : 1.0))
  {}

  // The threads use what is destroyed next.
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
      return {CentralNodeCode::InvalidSettings, "a stream needs a name"};
    if (CentralNodeStatus status = checkMinIntensity(min_intensity); !status.ok())
      return status;
    const std::unique_lock<std::shared_mutex> lock(streams_mutex_);
    const bool is_new = streams_
                            .try_emplace(name,
                                         pool_.get_executor(),
                                         name,
                                         min_intensity,
                                         settings_.decoder_limits)
                            .second;
    if (!is_new)
      return {CentralNodeCode::StreamExists,
              "there is a stream '" + name + "' already"};
    return {};
  }

  CentralNodeStatus
  setMinIntensity(const std::string& name, float min_intensity)
  {
    if (!settings_status_.ok())
      return settings_status_;
    if (CentralNodeStatus status = checkMinIntensity(min_intensity); !status.ok())
      return status;
    Entry* const entry = find(name);
    if (entry == nullptr)
      return unknownStream(name);
    entry->stream.setMinIntensity(min_intensity);
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
    Entry* const entry = find(name);
    if (entry == nullptr)
      return unknownStream(name);
    entry->stream.setOutlierRemoval(settings);
    return {};
  }

  CentralNodeStatus
  receive(const std::string& name,
          std::vector<std::uint8_t> bytes,
          std::optional<Time> stamp)
  {
    if (!settings_status_.ok())
      return settings_status_;
    Entry* const entry = find(name);
    if (entry == nullptr)
      return unknownStream(name);
    if (!entry->stream.admit(bytes.size(), settings_.max_waiting_frames))
      return {CentralNodeCode::TooManyWaiting,
              std::to_string(settings_.max_waiting_frames) + " frames of '" + name +
                  "' wait to be decoded; another one was refused"};
    {
      const std::lock_guard<std::mutex> lock(waiting_mutex_);
      ++waiting_;
    }
    boost::asio::post(entry->strand, [this, entry, stamp, bytes = std::move(bytes)] {
      entry->stream.decode(bytes, stamp, settings_.clock, listener_);
      const std::lock_guard<std::mutex> lock(waiting_mutex_);
      if (--waiting_ == 0)
        nothing_waits_.notify_all();
    });
    return {};
  }

  void
  waitUntilDecoded()
  {
    std::unique_lock<std::mutex> lock(waiting_mutex_);
    nothing_waits_.wait(lock, [this] { return waiting_ == 0; });
  }

  std::optional<LatestFrame>
  latestVoxels(const std::string& name, io::VoxelFrame& voxels) const
  {
    std::optional<LatestFrame> frame;
    if (const Entry* const entry = find(name))
      frame = entry->stream.latestVoxels(Time::min(), Time::max(), voxels);
    if (!frame)
      voxels = io::VoxelFrame();
    return frame;
  }

  void
  merge(io::VoxelFrame& merged)
  {
    if (!settings_status_.ok()) {
      merged = io::VoxelFrame();
      return;
    }
    const std::lock_guard<std::mutex> merge_lock(merge_mutex_);
    const Time now = settings_.clock();
    const Time oldest = now - settings_.max_merge_age;
    coordinates_.clear();
    intensities_.clear();
    {
      const std::shared_lock<std::shared_mutex> lock(streams_mutex_);
      for (const auto& [name, entry] : streams_)
        if (entry.stream.latestVoxels(oldest, now, merging_frame_))
          appendCentres(merging_frame_);
    }
    io::PointView points;
    points.coordinates = coordinates_.data();
    points.coordinate_stride = 3;
    points.intensities = intensities_.data();
    points.intensity_stride = 1;
    points.count = intensities_.size();
    // Merged frames are no stream: each has the grid and the scale that fit it.
    constexpr bool may_refit = true;
    merging_voxelizer_.voxelize(points, may_refit, merged);
    merged.depth_model.reset();
  }

  std::vector<StreamHealth>
  health() const
  {
    std::vector<StreamHealth> health;
    const std::shared_lock<std::shared_mutex> lock(streams_mutex_);
    for (const auto& [name, entry] : streams_)
      health.push_back(entry.stream.health(settings_.clock()));
    return health;
  }

private:
  /** \brief A stream, and what keeps its frames in order. */
  struct Entry {
    Entry(const boost::asio::thread_pool::executor_type& executor,
          const std::string& name,
          float min_intensity,
          const io::DecoderLimits& limits)
    : strand(executor), stream(name, min_intensity, limits)
    {}

    boost::asio::strand<boost::asio::thread_pool::executor_type> strand;
    ReceivedStream stream;
  };

  static CentralNodeStatus
  checkMinIntensity(float min_intensity)
  {
    if (std::isnan(min_intensity))
      return {CentralNodeCode::InvalidSettings,
              "min_intensity is not a number; it must be one"};
    return {};
  }

  // Streams are never removed, so that an entry outlives the lock.
  const Entry*
  find(const std::string& name) const
  {
    const std::shared_lock<std::shared_mutex> lock(streams_mutex_);
    const auto found = streams_.find(name);
    return found == streams_.end() ? nullptr : &found->second;
  }

  Entry*
  find(const std::string& name)
  {
    return const_cast<Entry*>(std::as_const(*this).find(name));
  }

  void
  appendCentres(const io::VoxelFrame& frame)
  {
    const float margin = io::faceMargin(settings_.resolution);
    io::VoxelCentres centres;
    for (std::size_t begin = 0; begin < frame.size(); begin += io::VoxelCentres::most) {
      const std::size_t count =
          io::voxelCentres(frame, symbol_intensities_, begin, centres);
      for (std::size_t i = 0; i < count; ++i) {
        coordinates_.insert(
            coordinates_.end(),
            {centres.x[i] + margin, centres.y[i] + margin, centres.z[i] + margin});
        intensities_.push_back(centres.intensity[i]);
      }
    }
  }

  const CentralNodeSettings settings_;
  const CentralNodeStatus settings_status_;
  const FrameListener listener_;
  boost::asio::thread_pool pool_; // outlives the strands

  mutable std::shared_mutex streams_mutex_; // of the map, not of its entries
  std::map<std::string, Entry> streams_;

  std::mutex waiting_mutex_;
  std::condition_variable nothing_waits_;
  std::size_t waiting_ = 0; // frames of all streams that are not decoded yet

  std::mutex
      merge_mutex_; // of everything below, members so that their memory is reused
  io::Voxelizer merging_voxelizer_;
  io::SymbolIntensities symbol_intensities_;
  io::VoxelFrame merging_frame_;
  std::vector<float> coordinates_;
  std::vector<float> intensities_;
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
CentralNode::setMinIntensity(const std::string& name, float min_intensity)
{
  return implementation_->setMinIntensity(name, min_intensity);
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

std::optional<LatestFrame>
CentralNode::latestVoxels(const std::string& name, io::VoxelFrame& voxels) const
{
  return implementation_->latestVoxels(name, voxels);
}

void
CentralNode::merge(io::VoxelFrame& merged)
{
  implementation_->merge(merged);
}

std::vector<StreamHealth>
CentralNode::health() const
{
  return implementation_->health();
}

} // namespace nodes
} // namespace pcl_ext
