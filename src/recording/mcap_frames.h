// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/bag_reader.h"
#include "recording/frame_source.h"
#include "recording/point_cloud_messages.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief The frames in the messages of an MCAP file or a rosbag2 folder. */
class McapFrames : public FrameSource {
public:
  /** \brief Finds the frames of an open file, whose compressed clouds are indexed.
   * \return NotARecording if there are none of this library
   */
  RecordingStatus
  open(BagReader reader, const std::string& path)
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
    addFrames(streams);
    return {};
  }

  RecordingStatus
  read(const IndexedFrame& indexed, RecordedFrame& frame) override
  {
    const BagEntry& entry = reader_.index()[static_cast<std::size_t>(indexed.at)];
    frame.offset = reader_.fileOffset(entry);
    frame.bytes.clear();
    RecordingStatus status = reader_.read(entry, message_);
    if (status.ok())
      status = readCloud();
    if (!status.ok())
      return status;
    frame.time = message_.log_time;
    frame.stamp = cloud_.stamp;
    frame.frame_id = cloud_.frame_id;
    frame.bytes.swap(cloud_.bytes);
    return {};
  }

  const std::vector<RecordingDamage>&
  damage() const override
  {
    return reader_.damage();
  }

  bool
  isUnfinished() const override
  {
    return reader_.isUnfinished();
  }

  std::uint64_t
  fileBytes() const override
  {
    return reader_.fileBytes();
  }

private:
  static constexpr std::size_t no_stream = ~std::size_t{0};

  RecordingStatus
  readCloud()
  {
    return readPointCloud(message_.bytes.data(),
                          message_.bytes.size(),
                          true,
                          cloud_,
                          encodingOf(reader_.channels()[message_.channel]));
  }

  /** \brief The format of each channel by one of its first messages; empty if none of
   * them can be read. */
  std::vector<std::string>
  formatsOfChannels()
  {
    constexpr unsigned int max_attempts = 8;
    std::vector<std::string> formats(reader_.channels().size());
    std::vector<unsigned int> attempts(formats.size());
    std::vector<BagEntry> first;
    for (const BagEntry& entry : reader_.index())
      if (attempts[entry.channel] < max_attempts) {
        ++attempts[entry.channel];
        first.push_back(entry);
      }
    // Each chunk is decompressed once.
    std::stable_sort(
        first.begin(), first.end(), [](const BagEntry& a, const BagEntry& b) {
          return a.chunk < b.chunk;
        });
    std::vector<bool> is_known(formats.size());
    for (const BagEntry& entry : first) {
      if (is_known[entry.channel] || !reader_.read(entry, message_).ok() ||
          !readCloud().ok())
        continue;
      formats[entry.channel] = cloud_.format;
      is_known[entry.channel] = true;
    }
    return formats;
  }

  /** \brief Adds the frames of all streams. Those of a stream stay in the order of the
   * file, as P-frames need the ones before, also if the clock was set back meanwhile.
   * \param[in] streams by channel
   */
  void
  addFrames(const std::vector<std::size_t>& streams)
  {
    const std::vector<BagEntry>& index = reader_.index();
    const auto isOfStream = [&](const BagEntry& entry) {
      return streams[entry.channel] != no_stream;
    };
    std::vector<IndexedFrame> frames;
    frames.reserve(static_cast<std::size_t>(
        std::count_if(index.begin(), index.end(), isOfStream)));
    for (std::size_t i = 0; i < index.size(); ++i)
      if (isOfStream(index[i]))
        frames.push_back({index[i].log_time, streams[index[i].channel], 0, i});
    const auto isBeforeInFile = [&index](const IndexedFrame& a, const IndexedFrame& b) {
      const BagEntry& first = index[static_cast<std::size_t>(a.at)];
      const BagEntry& second = index[static_cast<std::size_t>(b.at)];
      return std::tie(first.chunk, first.offset) <
             std::tie(second.chunk, second.offset);
    };
    std::sort(frames.begin(), frames.end(), isBeforeInFile);
    makeTimesRise(frames);
    std::sort(frames.begin(),
              frames.end(),
              [&](const IndexedFrame& a, const IndexedFrame& b) {
                return a.time != b.time ? a.time < b.time : isBeforeInFile(a, b);
              });
    takeFrames(std::move(frames));
  }

  /** \brief The status where there is no stream of this library, with what there is. */
  RecordingStatus
  nothingFound(const std::string& path, const std::vector<std::string>& formats) const
  {
    std::string clouds;
    std::string others;
    for (std::size_t i = 0; i < formats.size(); ++i) {
      const McapChannel& channel = reader_.channels()[i];
      if (isPointCloud(channel) || isRos1PointCloud(channel))
        clouds += (clouds.empty() ? "" : ", ") + channel.topic;
      else if (!formats[i].empty())
        others +=
            (others.empty() ? "" : ", ") + channel.topic + " (" + formats[i] + ")";
    }
    std::string message = "'" + path + "' has no clouds compressed by pcl_ext";
    if (!others.empty())
      message += "; those of other formats are " + others;
    if (!clouds.empty())
      message += "; it has clouds on " + clouds + ", which 'pcl_ext encode' compresses";
    return {RecordingCode::NotARecording, message};
  }

  BagReader reader_;
  McapMessage message_;
  PointCloudMessage cloud_;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
