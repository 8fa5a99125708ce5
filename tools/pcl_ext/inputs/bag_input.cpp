// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "console/exit_status.h"
#include "console/interruption.h"
#include "inputs/bag_place_reader.h"
#include "inputs/cloud_input.h"
#include "inputs/other_messages.h"
#include "inputs/recording_input.h"
#include "inputs/standard_input.h"
#include "outputs/frame_output.h"
#include "recording/mcap_stream.h"
#include "recording/point_cloud_messages.h"
#include "recording/rosbag2_folder.h"
#include "streams/stream_encoder.h"

#include <algorithm>
#include <array>
#include <deque>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

namespace pcl_ext::tools {

namespace {

namespace fs = std::filesystem;

using recording::BagEntry;
using recording::BagReader;
using recording::McapChannel;
using recording::McapMessage;
using recording::McapStream;
using recording::RecordingStatus;
using recording::Time;

/** \brief The clouds among the messages of bags. */
class BagInput : public CloudInput {
public:
  explicit BagInput(const InputOptions& options) : options_(options) {}

  const std::vector<std::string>&
  streams() const override
  {
    return streams_;
  }

  bool
  isBag() const override
  {
    return true;
  }

protected:
  static constexpr std::size_t none = ~std::size_t{0};

  /** \brief Makes streams of the channels with clouds that are wanted. Channels of one
   * topic, as of two publishers, are one stream.
   * \param[in] channels that were known before come first
   */
  void
  addChannels(const std::vector<McapChannel>& channels)
  {
    for (std::size_t i = stream_of_channel_.size(); i < channels.size(); ++i) {
      const McapChannel& channel = channels[i];
      const bool is_chosen =
          options_.topics.empty() ||
          std::find(options_.topics.begin(), options_.topics.end(), channel.topic) !=
              options_.topics.end();
      if (hasClouds(channel))
        topics_.push_back(channel.topic);
      if (!hasClouds(channel) || !is_chosen) {
        stream_of_channel_.push_back(none);
        continue;
      }
      const auto known = std::find(streams_.begin(), streams_.end(), channel.topic);
      stream_of_channel_.push_back(static_cast<std::size_t>(known - streams_.begin()));
      if (known == streams_.end())
        streams_.push_back(channel.topic);
    }
    clouds_.resize(streams_.size());
    colours_.resize(streams_.size());
  }

  /** \brief Counts a message of a stream.
   * \param[out] cloud its number and names
   * \return false if it is not wanted
   */
  bool
  count(std::size_t stream, InputCloud& cloud)
  {
    cloud.stream = stream;
    cloud.number = clouds_[stream]++;
    cloud.source = streams_[stream] + ", frame " + std::to_string(cloud.number);
    cloud.failure.clear();
    return cloud.number >= options_.frames.begin && cloud.number < options_.frames.end;
  }

  /** \brief Sets a cloud by its message, after those of its stream before it. */
  void
  readNext(const McapChannel& channel, InputCloud& cloud)
  {
    Colours& colours = colours_[cloud.stream];
    cloud.colour_scale = colours.scale;
    readCloud(channel, options_.packs_colours, cloud, message_);
    if (colours.is_known || !cloud.failure.empty())
      return;
    colours = {cloud.colour_scale, hasPoints(cloud.cloud)};
  }

  /** \brief True if a stream may have clouds that are wanted, of those that are known
   * or named by --topics. */
  bool
  wantsMore() const
  {
    const auto isUnknown = [this](const std::string& topic) {
      return std::find(topics_.begin(), topics_.end(), topic) == topics_.end();
    };
    return clouds_.empty() ||
           std::any_of(options_.topics.begin(), options_.topics.end(), isUnknown) ||
           std::any_of(clouds_.begin(), clouds_.end(), [this](std::size_t clouds) {
             return clouds < options_.frames.end;
           });
  }

  /** \brief Whether a type has a name that drivers give to points and packets of them. */
  static bool
  mayBeClouds(const McapChannel& channel)
  {
    constexpr std::array parts = {
        "PointCloud", "CustomMsg", "VelodyneScan", "PacketMsg", "Packets"};
    return std::any_of(parts.begin(), parts.end(), [&channel](const char* part) {
      return channel.schema.name.find(part) != std::string::npos;
    });
  }

  /** \brief What there is in place of clouds.
   * \param[in] name of the input
   */
  static std::string
  whyNoClouds(const std::string& name, const std::vector<McapChannel>& channels)
  {
    std::string topics;
    for (const McapChannel& channel : channels) {
      if (recording::isCompressedPointCloud(channel))
        return "the clouds of " + channel.topic + " in '" + name +
               "' are compressed already: see them with 'pcl_ext info'";
      if (mayBeClouds(channel))
        return "the clouds of " + channel.topic + " in '" + name + "' are " +
               channel.schema.name + " in the encoding '" + channel.message_encoding +
               "', which cannot be read: record them as sensor_msgs/msg/PointCloud2 "
               "in CDR, which the sensor's driver or a node of it converts them to";
      topics += (topics.empty() ? "" : ", ") + channel.topic;
    }
    return "'" + name + "' has no clouds (sensor_msgs/msg/PointCloud2); " +
           (topics.empty() ? "it has no topics" : "its topics are " + topics);
  }

  InputOptions options_;
  std::vector<std::string> topics_; // with clouds
  std::vector<std::string> streams_;
  std::vector<std::size_t> stream_of_channel_; // or none
  std::vector<std::size_t> clouds_;            // of each stream that were met

private:
  /** \brief What tells how colours of a stream are read. */
  struct Colours {
    clouds::ColourScale scale;
    bool is_known = false; // as there was a cloud with points
  };

  std::vector<Colours> colours_;         // of each stream
  recording::PointCloudMessage message_; // a member so that its memory is reused
};

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

/** \brief An MCAP file that comes through a pipe: its contents as they come. */
class McapPipe : public BagInput {
public:
  McapPipe(recording::Descriptor descriptor,
           const std::string& name,
           const InputOptions& options)
  : BagInput(options)
  , descriptor_(std::move(descriptor))
  , name_(name)
  , stream_(
        [this](std::uint8_t* bytes, std::size_t count) {
          if (before_waiting_ && mustWaitFor(descriptor_.get()))
            before_waiting_();
          return readPipe(descriptor_.get(), bytes, count);
        },
        name)
  {
    // The profile is known then.
    advance();
  }

  std::size_t
  size() const override
  {
    return 0;
  }

  std::string
  profile() const override
  {
    return stream_.profile();
  }

  const std::vector<McapChannel>&
  channels() const override
  {
    return stream_.channels();
  }

  std::vector<std::string>
  damage() const override
  {
    std::vector<std::string> lines;
    if (!isInterrupted())
      for (const recording::RecordingDamage& place : stream_.damage())
        lines.push_back(describe(place));
    if (topics_.empty())
      lines.push_back(whyNoClouds(name_, channels()));
    try {
      checkTopics(options_.topics, topics_);
    }
    catch (const UsageError& error) {
      lines.push_back(error.what());
    }
    return lines;
  }

  bool
  isLive() const override
  {
    return true;
  }

  void
  setBeforeWaiting(std::function<void()> action) override
  {
    before_waiting_ = std::move(action);
  }

  Found
  next(InputCloud& cloud, McapMessage& other) override
  {
    while (wantsMore()) {
      if (!is_at_hand_)
        advance();
      is_at_hand_ = false;
      if (found_ == McapStream::Found::End)
        return Found::End;
      if (found_ != McapStream::Found::Message)
        return Found::Extra;
      const std::size_t stream = stream_of_channel_[stream_.message().channel];
      if (stream == none) {
        if (!hasBegun()) {
          hold();
          continue;
        }
        std::swap(other, stream_.message());
        return Found::OtherMessage;
      }
      if (clouds_[stream] >= options_.frames.begin && !held_.empty()) {
        std::swap(other, held_.front());
        other.log_time = stream_.message().log_time;
        held_.pop_front();
        is_at_hand_ = true;
        return Found::OtherMessage;
      }
      if (!count(stream, cloud))
        continue;
      std::swap(cloud.message, stream_.message());
      readNext(channels()[cloud.message.channel], cloud);
      return Found::Cloud;
    }
    return Found::End;
  }

  void
  copyExtra(FrameOutput& output) override
  {
    if (found_ == McapStream::Found::Metadata)
      output.write(stream_.metadata());
    else
      output.write(stream_.attachment());
  }

private:
  /** \brief Whether a first one of the wanted clouds was met. */
  bool
  hasBegun() const
  {
    const std::size_t begin = options_.frames.begin;
    return begin == 0 ||
           std::any_of(clouds_.begin(), clouds_.end(), [begin](std::size_t clouds) {
             return clouds > begin;
           });
  }

  /** \brief Keeps a message until then, if it is a latched one. */
  void
  hold()
  {
    const std::size_t channel = stream_.message().channel;
    const std::size_t most = latchedMessages(channels()[channel]);
    if (most == 0)
      return;
    const auto isOfChannel = [channel](const McapMessage& message) {
      return message.channel == channel;
    };
    const auto held = std::count_if(held_.begin(), held_.end(), isOfChannel);
    if (static_cast<std::size_t>(held) == most)
      held_.erase(std::find_if(held_.begin(), held_.end(), isOfChannel));
    held_.push_back(std::move(stream_.message()));
  }

  void
  advance()
  {
    found_ = stream_.next();
    is_at_hand_ = true;
    addChannels(stream_.channels());
  }

  recording::Descriptor descriptor_;
  std::string name_;
  std::function<void()> before_waiting_;
  McapStream stream_;
  McapStream::Found found_ = McapStream::Found::End;
  bool is_at_hand_ = false; // it was found, and not taken yet
  std::deque<McapMessage> held_;
};

} // namespace

std::unique_ptr<CloudInput>
openBag(const std::string& path, const InputOptions& options)
{
  return std::make_unique<BagFileInput>(path, options);
}

std::unique_ptr<CloudInput>
openMcapPipe(recording::Descriptor descriptor,
             const std::string& name,
             const InputOptions& options)
{
  return std::make_unique<McapPipe>(std::move(descriptor), name, options);
}

} // namespace pcl_ext::tools
