#include "live/piped_frames.h"

#include <pcl_ext/compression/frame_decoder.h>

#include "console/interruption.h"
#include "inputs/standard_input.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace pcl_ext {
namespace tools {

namespace {

constexpr std::size_t piece_bytes = std::size_t{1} << 16;
constexpr char mcap_magic[] = "\x89MCAP0\r\n";

/** \brief Limits for looking at frames without decoding them. */
io::DecoderLimits
limitsOfFrames()
{
  io::DecoderLimits limits = io::DecoderLimits::none();
  limits.max_frame_bytes = io::DecoderLimits().max_frame_bytes;
  return limits;
}

} // namespace

bool
PipedFrames::receive(const std::function<void()>& meanwhile)
{
  while (!isInterrupted()) {
    if (meanwhile) {
      constexpr int patience_ms = 100;
      pollfd input{STDIN_FILENO, POLLIN, 0};
      const int ready = ::poll(&input, 1, patience_ms);
      meanwhile();
      if (ready == 0)
        continue;
    }
    const std::size_t before = bytes_.size();
    bytes_.resize(before + piece_bytes);
    const std::size_t count = readPipe(STDIN_FILENO, &bytes_[before], piece_bytes);
    bytes_.resize(before + count);
    if (count == 0)
      return false;
    if (bytes_.size() >= needed_)
      return true;
  }
  return false;
}

/** \brief The frame's stamp, or the time now if frames have none. */
std::chrono::nanoseconds
PipedFrames::timeOf(const io::FrameDescription& frame)
{
  if (frame.is_i_frame)
    stamp_ = frame.stamp;
  else if (frame.stamp_difference)
    stamp_ = stamp_.value_or(0) + static_cast<std::uint64_t>(*frame.stamp_difference);
  constexpr std::uint64_t most =
      std::uint64_t{std::numeric_limits<std::int64_t>::max()} / 1000;
  if (stamp_ && *stamp_ <= most)
    return std::chrono::microseconds(static_cast<std::int64_t>(*stamp_));
  return std::chrono::system_clock::now().time_since_epoch();
}

void
PipedFrames::publishFrames()
{
  std::size_t begin = 0;
  needed_ = 1;
  while (begin < bytes_.size() && !isInterrupted()) {
    const std::uint8_t* const bytes = bytes_.data() + begin;
    const std::size_t count = bytes_.size() - begin;
    const io::FrameSize size = io::frameSize(bytes, count, limitsOfFrames());
    if (size.needed > count) {
      needed_ = size.needed;
      break;
    }
    if (size.status.ok()) {
      const auto time = timeOf(io::describeFrame(bytes, count, limitsOfFrames()));
      output_.publish(stream_, time, {bytes, bytes + size.known});
      ++frames_;
    }
    else {
      if (skipped_bytes_ == 0)
        first_problem_ = size.status.message();
      skipped_bytes_ += size.drop;
    }
    begin += size.known + size.drop;
  }
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(begin));
}

void
PipedFrames::run(const std::function<void()>& meanwhile)
{
  stream_ = output_.addStream(name_, {});
  needed_ = sizeof(mcap_magic) - 1;
  bool is_first = true;
  while (receive(meanwhile)) {
    if (is_first && std::equal(mcap_magic,
                               mcap_magic + needed_,
                               bytes_.begin(),
                               [](char a, std::uint8_t b) {
                                 return static_cast<std::uint8_t>(a) == b;
                               }))
      throw std::runtime_error(
          "the standard input is an MCAP file, which can be read when it is complete: "
          "name the file; frames that arrive are .pcxi, as pcl_ext encode -o - writes "
          "them");
    is_first = false;
    publishFrames();
  }
  if (frames_ == 0 && !isInterrupted())
    throw std::runtime_error("the standard input has no frame" +
                             (bytes_.empty() && first_problem_.empty() ? ": it is empty"
                              : first_problem_.empty()
                                  ? ": it ends within the first one"
                                  : ": " + first_problem_));
  if (skipped_bytes_ > 0)
    console_.remark(std::to_string(skipped_bytes_) +
                    " bytes of the standard input are no frame: " + first_problem_);
  if (!bytes_.empty() && !isInterrupted())
    console_.remark("the standard input ends within a frame, which is lost");
  output_.end();
}

} // namespace tools
} // namespace pcl_ext
