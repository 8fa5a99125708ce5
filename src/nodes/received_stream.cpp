#include "received_stream.h"

#include <pcl_ext/filters/faint_voxels.h>

#include "latency.h"

#include <utility>

namespace pcl_ext {
namespace nodes {

namespace {

/** \brief True if bytes held no frame at all, so that none of the sender's is missing. */
bool
wasNoFrame(io::CompressionCode code)
{
  return code == io::CompressionCode::NoFrame ||
         code == io::CompressionCode::EndOfStream;
}

} // namespace

ReceivedStream::ReceivedStream(const std::string& name,
                               float min_intensity,
                               const io::DecoderLimits& limits)
: decoder_(limits), min_intensity_(min_intensity)
{
  health_.name = name;
}

void
ReceivedStream::setOutlierRemoval(
    const std::optional<VoxelOutlierRemovalSettings>& settings)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  outlier_settings_ = settings;
  are_outlier_settings_new_ = true;
}

ReceivedStream::WaitingFrame
ReceivedStream::takeNext()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  WaitingFrame next = std::move(waiting_.front());
  waiting_.pop_front();
  return next;
}

bool
ReceivedStream::endTurn()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  has_turn_ = !waiting_.empty();
  return has_turn_;
}

void
ReceivedStream::decodeNext(const Clock& clock, const FrameListener& listener)
{
  const WaitingFrame frame = takeNext();
  const std::vector<std::uint8_t>& bytes = frame.bytes;
  std::optional<Time> stamp = frame.stamp;
  // All streams of a thread decode into the same memory, which then is in its caches; each
  // has memory of its own for what it keeps.
  thread_local io::VoxelFrame decoded;
  const auto start = std::chrono::steady_clock::now();
  const io::CompressionStatus status =
      decoder_.decode(bytes.data(), bytes.size(), decoded);
  const io::CodedFrameStatistics& coding = decoder_.statistics();
  std::size_t outliers = 0;
  if (status.ok()) {
    outliers = removeOutliers(decoded);
    removeFaintVoxels(decoded, min_intensity_, kept_);
  }
  const std::chrono::duration<double> cycle = std::chrono::steady_clock::now() - start;

  if (status.ok() && !stamp && decoder_.stamp())
    stamp = timeOfStamp(decoder_.stamp()->stamp);
  const Time now = clock();
  const double latency = latencySeconds(stamp.value_or(Time(0)), now);
  const bool wants_i_frame = wantsIFrame(status.code());
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    unnumbered_ += frame.refused_before;
    health_.i_frame_requests += wants_i_frame ? 1 : 0;
    if (status.ok()) {
      countDecoded(coding.frame_number);
      health_.voxels = coding.voxels;
      health_.kept_voxels = kept_.size();
      health_.outliers_removed = outliers;
      health_.last_decoded = now;
      window_.add({now, bytes.size(), cycle.count(), latency});
      std::swap(kept_, latest_);
      latest_stamp_ = stamp.value_or(Time(0));
    }
    else
      countFailed(status);
  }
  // Only this thread changes the latest voxels, so that it may read them unlocked.
  static const io::VoxelFrame no_voxels;
  static const io::CodedFrameStatistics no_statistics;
  if (listener)
    listener({health_.name,
              stamp.value_or(Time(0)),
              status,
              status.ok() ? latest_ : no_voxels,
              status.ok() ? coding : no_statistics,
              wants_i_frame});
}

std::size_t
ReceivedStream::removeOutliers(io::VoxelFrame& frame)
{
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (std::exchange(are_outlier_settings_new_, false)) {
      outlier_removal_.reset();
      if (outlier_settings_)
        outlier_removal_.emplace(*outlier_settings_);
    }
  }
  return outlier_removal_ ? outlier_removal_->filter(frame) : 0;
}

bool
ReceivedStream::wantsIFrame(io::CompressionCode code)
{
  switch (code) {
  case io::CompressionCode::Ok:
    failures_in_a_row_ = 0;
    return false;
  case io::CompressionCode::MissingReference:
  case io::CompressionCode::Corrupt:
  case io::CompressionCode::Truncated:
  case io::CompressionCode::InputFailed:
    // An answer takes a frame or two to arrive; a request may be lost, too.
    return failures_in_a_row_++ % 3 == 0;
  default:
    return false; // an I-frame would not help
  }
}

void
ReceivedStream::countDecoded(std::uint32_t frame_number)
{
  // A number that is not above the last one is that of a sender that began again.
  if (last_number_ && frame_number > *last_number_) {
    const std::size_t missing = frame_number - *last_number_ - 1;
    if (missing > unnumbered_)
      health_.frames_lost += missing - unnumbered_;
  }
  last_number_ = frame_number;
  unnumbered_ = 0;
  ++health_.frames_decoded;
  health_.in_sync = true;
}

void
ReceivedStream::countFailed(const io::CompressionStatus& status)
{
  ++health_.frames_failed;
  health_.last_failure = status;
  if (wasNoFrame(status.code()))
    return;
  ++unnumbered_;
  health_.in_sync = false;
}

std::optional<LatestFrame>
ReceivedStream::latestVoxels(Time oldest, Time newest, io::VoxelFrame& voxels) const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (health_.frames_decoded == 0 || health_.last_decoded < oldest ||
      health_.last_decoded > newest)
    return std::nullopt;
  voxels = latest_;
  return LatestFrame{latest_stamp_, health_.frames_decoded};
}

StreamHealth
ReceivedStream::health(Time now) const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  StreamHealth health = health_;
  health.rates = window_.rates(now);
  return health;
}

} // namespace nodes
} // namespace pcl_ext
