// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "console/exit_status.h"
#include "inputs/bag_input.h"
#include "inputs/bag_place_reader.h"
#include "inputs/other_messages.h"
#include "inputs/recording_input.h"
#include "recording/rosbag2_folder.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <tuple>

namespace pcl_ext::tools {

namespace {

namespace fs = std::filesystem;

using recording::BagEntry;
using recording::BagReader;
using recording::McapChannel;
using recording::McapMessage;
using recording::RecordingStatus;
using recording::Time;

/** \brief A file of a bag or a rosbag2 folder: its clouds and all other messages. */
class BagFileInput : public BagInput {
public:
  BagFileInput(const std::string& path, const InputOptions& options)
  : BagInput(options), path_(path)
  {
    if (const RecordingStatus status = reader_.open(path); !status.ok())
      throw std::runtime_error(status.message());
    damage_at_first_ = reader_.damage().size();
    addChannels(reader_.channels());
    const std::string damage =
        reader_.damage().empty() ? std::string() : describe(reader_.damage().front());
    if (topics_.empty() && reader_.channels().empty() && !damage.empty())
      throw std::runtime_error("no topic of '" + path + "' can be read; " + damage);
    if (topics_.empty())
      throw std::runtime_error(whyNoClouds(path, reader_.channels()) +
                               (damage.empty() ? std::string() : "; " + damage));
    checkTopics(options.topics, topics_);
    chooseFrames();
  }

  std::size_t
  size() const override
  {
    return reader_.index().size();
  }

  std::string
  profile() const override
  {
    return reader_.profile();
  }

  const std::vector<McapChannel>&
  channels() const override
  {
    return reader_.channels();
  }

  BagReader*
  bag() override
  {
    return &reader_;
  }

  std::vector<std::string>
  damage() const override
  {
    std::vector<std::string> lines;
    // What was met while reading is in the order of the file, whoever met it.
    std::set<std::tuple<std::string, std::uint64_t, std::string>> met;
    const auto add = [&](const BagReader& reader) {
      for (std::size_t i = damage_at_first_; i < reader.damage().size(); ++i) {
        const recording::RecordingDamage& place = reader.damage()[i];
        met.emplace(place.file, place.offset, describe(place));
      }
    };
    for (std::size_t i = 0; i < damage_at_first_; ++i)
      lines.push_back(describe(reader_.damage()[i]));
    add(reader_);
    for (const auto& reader : place_readers_)
      add(reader->reader());
    for (const auto& [file, offset, line] : met)
      lines.push_back(line);
    if (lines.empty() && reader_.isUnfinished())
      lines.push_back("the recorder of '" + path_ +
                      "' did not complete it; all that is in it was read");
    return lines;
  }

  std::vector<std::string>
  remarks() const override
  {
    std::vector<std::string> remarks;
    if (fs::is_directory(path_) && !recording::isRosbag2Folder(path_))
      remarks.push_back(
          "'" + path_ +
          "' has no metadata.yaml; its files are read as parts of one bag");
    for (const McapChannel& channel : channels())
      if (!hasClouds(channel) && mayBeClouds(channel) &&
          !recording::isCompressedPointCloud(channel))
        remarks.push_back(channel.topic + ": messages of the type " +
                          channel.schema.name +
                          " are not encoded; clouds are sensor_msgs/msg/PointCloud2");
    const bool has_topics_of_ros1 =
        std::any_of(channels().begin(), channels().end(), [](const auto& channel) {
          return channel.message_encoding == "ros1" && !hasClouds(channel);
        });
    if (has_topics_of_ros1)
      remarks.push_back("'" + path_ +
                        "' is of ROS 1; bags are written as MCAP, with other topics as "
                        "they are, which ROS 2 does not play");
    if (!reader_.hasDatabases())
      return remarks;
    const bool lacks_definitions =
        std::any_of(channels().begin(), channels().end(), [](const auto& channel) {
          return channel.schema.text.empty();
        });
    remarks.push_back(
        "'" + path_ + "' has the storage sqlite3; bags are written as MCAP" +
        (lacks_definitions
             ? ", with other topics as they are: ROS 2 plays them, but some viewers "
               "need the definitions of their types, which are not in the bag"
             : ""));
    return remarks;
  }

  bool
  leaveUnread() override
  {
    // A bag that is cut off is searched for messages whenever it is opened, one that is
    // compressed is decompressed, and each reader has all files of a folder open.
    constexpr std::ptrdiff_t most_files = 16;
    leaves_unread_ = damage_at_first_ == 0 && !reader_.isUnfinished() &&
                     !reader_.isCompressed() &&
                     (!fs::is_directory(path_) ||
                      std::distance(fs::directory_iterator(path_), {}) <= most_files);
    return leaves_unread_;
  }

  std::shared_ptr<PlaceReader>
  placeReader() override
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const auto& reader : place_readers_)
      if (reader.use_count() == 1)
        return reader;
    place_readers_.push_back(
        std::make_shared<BagPlaceReader>(path_, options_.packs_colours));
    return place_readers_.back();
  }

  Found
  next(InputCloud& cloud, McapMessage& other) override
  {
    while (next_ < reader_.index().size()) {
      const BagEntry& entry = reader_.index()[next_++];
      const std::size_t stream = stream_of_channel_[entry.channel];
      cloud.is_unread = leaves_unread_;
      cloud.place = next_ - 1;
      if (stream != none) {
        if (!count(stream, cloud))
          continue;
        if (leaves_unread_) {
          cloud.message.log_time = entry.log_time;
          return Found::Cloud;
        }
        if (const RecordingStatus status = reader_.read(entry, cloud.message);
            status.ok())
          readNext(reader_.channels()[entry.channel], cloud);
        else
          cloud.failure = status.message();
        return Found::Cloud;
      }
      if (part_ && !std::binary_search(part_->begin(), part_->end(), next_ - 1))
        continue;
      other.channel = entry.channel;
      cloud.is_unread &= entry.log_time >= part_begin_;
      // What cannot be read is part of damage().
      if (cloud.is_unread)
        return Found::OtherMessage;
      if (reader_.read(entry, other).ok()) {
        other.log_time = std::max(other.log_time, part_begin_);
        return Found::OtherMessage;
      }
    }
    return Found::End;
  }

private:
  /** \brief Chooses other messages for the wanted frames as RecordingInput does.
   * \throws UsageError if no stream has such frames
   */
  void
  chooseFrames()
  {
    const std::size_t begin = options_.frames.begin;
    const std::size_t end = options_.frames.end;
    std::vector<std::vector<Time>> clouds(streams_.size());
    std::vector<std::size_t> others; // in the index
    std::size_t longest = 0;
    for (std::size_t i = 0; i < reader_.index().size(); ++i) {
      const BagEntry& entry = reader_.index()[i];
      const std::size_t stream = stream_of_channel_[entry.channel];
      if (stream == none) {
        others.push_back(i);
        continue;
      }
      clouds[stream].push_back(entry.log_time);
      longest = std::max(longest, clouds[stream].size());
    }
    if (longest > 0 && longest <= begin)
      throw UsageError(describeFramesBeyond(options_, longest));
    if (longest == 0 || (begin == 0 && end >= longest))
      return;
    Time from = Time::max();
    Time to = Time::min();
    for (const std::vector<Time>& times : clouds)
      if (times.size() > begin) {
        from = std::min(from, times[begin]);
        to = std::max(to, end < times.size() ? times[end] : times.back() + Time(1));
      }
    if (begin > 0)
      part_begin_ = from;
    part_ =
        othersOfPart(reader_, others, part_begin_, end >= longest ? Time::max() : to);
  }

  std::string path_;
  BagReader reader_;
  std::size_t damage_at_first_ = 0; // when it was opened
  std::size_t next_ = 0;
  std::optional<std::vector<std::size_t>> part_; // other messages in it; none: all
  Time part_begin_ = Time::min();                // earlier ones get this time
  bool leaves_unread_ = false;
  std::mutex mutex_; // of the following
  std::vector<std::shared_ptr<BagPlaceReader>> place_readers_;
};

} // namespace

std::unique_ptr<CloudInput>
openBag(const std::string& path, const InputOptions& options)
{
  return std::make_unique<BagFileInput>(path, options);
}

} // namespace pcl_ext::tools
