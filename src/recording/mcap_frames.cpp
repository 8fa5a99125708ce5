#include "recording/mcap_frames.h"

#include "recording/format_name.h"

#include <algorithm>
#include <map>
#include <utility>

namespace pcl_ext {
namespace recording {

namespace {

constexpr std::size_t no_stream = ~std::size_t{0};

} // namespace

/** \brief The format of each channel by its first message that can be read; empty where there
 * is none. */
std::vector<std::string>
McapFrames::formatsOfChannels()
{
  std::vector<std::string> formats(reader_.channels().size());
  std::vector<bool> is_known(formats.size());
  std::size_t unknown = static_cast<std::size_t>(std::count_if(
      reader_.channels().begin(), reader_.channels().end(), isCompressedPointCloud));
  for (const McapEntry& entry : reader_.index()) {
    if (unknown == 0)
      break;
    if (is_known[entry.channel] || !reader_.read(entry, message_).ok() ||
        !readPointCloud(message_.bytes.data(), message_.bytes.size(), true, cloud_)
             .ok())
      continue;
    formats[entry.channel] = cloud_.format;
    is_known[entry.channel] = true;
    --unknown;
  }
  return formats;
}

/** \brief The status where there is no stream of this library, with what there is. */
RecordingStatus
McapFrames::nothingFound(const std::string& path,
                         const std::vector<std::string>& formats) const
{
  std::string clouds;
  std::string others;
  for (std::size_t i = 0; i < formats.size(); ++i) {
    const McapChannel& channel = reader_.channels()[i];
    if (isPointCloud(channel))
      clouds += (clouds.empty() ? "" : ", ") + channel.topic;
    else if (!formats[i].empty())
      others += (others.empty() ? "" : ", ") + channel.topic + " (" + formats[i] + ")";
  }
  std::string message = "'" + path + "' has no clouds compressed by pcl_ext";
  if (!others.empty())
    message += "; those of other formats are " + others;
  if (!clouds.empty())
    message += "; it has clouds on " + clouds + ", which 'pcl_ext encode' compresses";
  return {RecordingCode::NotARecording, message};
}

RecordingStatus
McapFrames::open(McapReader reader, const std::string& path)
{
  reader_ = std::move(reader);
  const std::vector<McapChannel>& channels = reader_.channels();
  const std::vector<std::string> formats = formatsOfChannels();
  std::vector<std::size_t> streams(channels.size(), no_stream); // by channel
  std::map<std::string, int> uses;                              // of a name
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (!isCompressedPointCloud(channels[i]) ||
        (!formats[i].empty() && !isFormatOfFrames(formats[i])))
      continue;
    RecordedStream stream;
    const int use = ++uses[channels[i].topic];
    stream.name = channels[i].topic + (use > 1 ? "#" + std::to_string(use) : "");
    stream.metadata = channels[i].metadata;
    stream.channel = i;
    stream.has_times = true;
    streams[i] = streams_.size();
    streams_.push_back(std::move(stream));
  }
  if (streams_.empty())
    return nothingFound(path, formats);
  const std::vector<McapEntry>& index = reader_.index();
  for (std::size_t i = 0; i < index.size(); ++i)
    if (streams[index[i].channel] != no_stream)
      addFrame(streams[index[i].channel], index[i].log_time, i);
  return {};
}

RecordingStatus
McapFrames::read(const FramePlace& place, RecordedFrame& frame)
{
  const McapEntry& entry = reader_.index()[static_cast<std::size_t>(place.at)];
  frame.offset = reader_.fileOffset(entry);
  frame.bytes.clear();
  RecordingStatus status = reader_.read(entry, message_);
  if (status.ok())
    status = readPointCloud(message_.bytes.data(), message_.bytes.size(), true, cloud_);
  if (!status.ok())
    return status;
  frame.stamp = cloud_.stamp;
  frame.frame_id = cloud_.frame_id;
  frame.message_points = std::uint64_t{cloud_.width} * cloud_.height;
  frame.bytes.swap(cloud_.bytes);
  return {};
}

} // namespace recording
} // namespace pcl_ext
