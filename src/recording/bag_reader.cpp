// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/bag_reader.h"

#include "recording/bag_file.h"
#include "recording/chunk_cache.h"
#include "recording/compressed_input.h"
#include "recording/files.h"
#include "recording/guarded.h"
#include "recording/mcap/mcap_file.h"
#include "recording/ros1/ros1_file.h"
#include "recording/rosbag2_folder.h"
#include "recording/sqlite/bag_database.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <system_error>
#include <tuple>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording {

namespace {

/** \brief What channels of several files agree in if they are one. */
auto
identityOf(const McapChannel& channel)
{
  return std::tie(channel.topic,
                  channel.message_encoding,
                  channel.schema.name,
                  channel.schema.encoding,
                  channel.schema.text);
}

/** \brief A bag may have more files than a process may open. */
constexpr std::size_t max_open_files = 64;

bool
beginsWith(const std::vector<std::uint8_t>& bytes, const std::string& text)
{
  return bytes.size() >= text.size() &&
         std::equal(
             text.begin(), text.end(), bytes.begin(), [](char a, std::uint8_t b) {
               return static_cast<std::uint8_t>(a) == b;
             });
}

bool
isFolder(const std::string& path)
{
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

} // namespace

struct BagReader::IndexedFile {
  std::unique_ptr<BagFile> bag_file;
  std::map<std::uint16_t, std::size_t> channels; // index in all channels, by id
  std::vector<mcap::RecordExtent> metadata;
  std::vector<mcap::RecordExtent> attachments;
};

BagReader::BagReader() : cache_(new ChunkCache) {}
BagReader::~BagReader() = default;
BagReader::BagReader(BagReader&&) noexcept = default;
BagReader&
BagReader::operator=(BagReader&&) noexcept = default;

void
BagReader::addChannels(std::map<std::uint16_t, McapChannel>& channels,
                       IndexedFile& file)
{
  channels_.reserve(channels_.size() + channels.size()); // so that none moves below
  // Each continues at most one channel of this file: a topic may have several.
  std::multimap<decltype(identityOf(channels_.front())), std::size_t> earlier;
  for (std::size_t number = 0; number < channels_.size(); ++number)
    earlier.emplace(identityOf(channels_[number]), number);
  for (auto& [id, channel] : channels) {
    const auto same = earlier.lower_bound(identityOf(channel));
    if (same != earlier.end() && same->first == identityOf(channel)) {
      file.channels[id] = same->second;
      earlier.erase(same);
      continue;
    }
    file.channels[id] = channels_.size();
    channels_.push_back(std::move(channel));
  }
}

RecordingStatus
BagReader::addFile(InputFile&& input, const ChannelFilter& wants)
{
  FileContents contents;
  std::string damage;
  if (isZstd(input)) {
    is_compressed_ = true;
    if (RecordingStatus status = decompressFile(input, damage); !status.ok())
      return status;
  }
  IndexedFile file;
  file.bag_file = bagFileOf(std::move(input));
  if (RecordingStatus status = file.bag_file->findContents(wants, contents);
      !status.ok())
    return status;
  if (!damage.empty())
    contents.damage.insert(contents.damage.begin(),
                           {0, damage, file.bag_file->file().path()});
  const std::size_t number = files_.size();
  file_bytes_ += file.bag_file->file().size();
  cache_->allowFile(file.bag_file->file().size());
  has_databases_ |= file.bag_file->hasRows();
  if (number == 0)
    profile_ = contents.profile;
  addChannels(contents.channels, file);
  const std::size_t first_section = sections_.size();
  for (const Section& section : contents.sections)
    sections_.push_back({number, section});
  index_.reserve(index_.size() + contents.messages.size());
  for (const IndexedMessage& message : contents.messages)
    index_.push_back({mcap::messageTime(message.log_time),
                      file.channels[message.channel_id],
                      first_section + message.section,
                      message.offset});
  file.metadata = std::move(contents.metadata);
  file.attachments = std::move(contents.attachments);
  for (RecordingDamage& place : contents.damage) {
    known_damage_.emplace(number, place.offset);
    damage_.push_back(std::move(place));
  }
  is_unfinished_ |= !contents.has_end;
  files_.push_back(std::move(file));
  openFile(number);
  return {};
}

std::unique_ptr<BagFile>
BagReader::bagFileOf(InputFile&& file)
{
  if (sqlite::isDatabase(file))
    return std::make_unique<sqlite::BagDatabase>(std::move(file));
  if (beginsWith(beginningOf(file, sizeof(ros1::magic)), ros1::magic))
    return std::make_unique<ros1::Ros1File>(std::move(file), *cache_);
  return std::make_unique<mcap::McapFile>(std::move(file), *cache_);
}

/** \brief A file of the bag, which is opened if it is not open, in place of the one
 * that was not used for longest. */
BagFile&
BagReader::openFile(std::size_t number)
{
  const auto found = std::find(open_files_.begin(), open_files_.end(), number);
  if (found != open_files_.end())
    open_files_.erase(found);
  else if (open_files_.size() == max_open_files) {
    files_[open_files_.front()].bag_file->file().suspend();
    open_files_.erase(open_files_.begin());
  }
  open_files_.push_back(number);
  files_[number].bag_file->file().resume();
  return *files_[number].bag_file;
}

RecordingStatus
BagReader::openPath(const std::string& path, const ChannelFilter& wants)
{
  std::vector<std::string> paths;
  const bool is_folder = isFolder(path);
  if (is_folder) {
    if (RecordingStatus status = filesOfRosbag2Folder(path, paths); !status.ok())
      return status;
  }
  else
    paths.push_back(path);
  RecordingStatus first_failure;
  for (const std::string& file_path : paths) {
    InputFile file;
    RecordingStatus status = file.open(file_path);
    if (status.ok())
      status = addFile(std::move(file), wants);
    if (status.ok())
      continue;
    // The last file of a bag may be empty after a power failure.
    if (paths.size() == 1 || status.code() != RecordingCode::NotARecording)
      return status;
    damage_.push_back({0, "the file is not one of a bag", file_path});
    is_unfinished_ = true;
    first_failure = first_failure.ok() ? status : first_failure;
  }
  if (is_folder) {
    addQosOfMetadata(path, channels_);
    for (RecordingDamage& damage : findMissingFiles(path))
      damage_.push_back(std::move(damage));
    if (damage_.empty() && !wants)
      if (auto damage = findMissingMessages(path, index_.size()))
        damage_.push_back(std::move(*damage));
  }
  sortIndex();
  return files_.empty() ? first_failure : RecordingStatus();
}

void
BagReader::sortIndex()
{
  // In place: a stable sort would take as much memory again.
  std::sort(index_.begin(), index_.end(), [](const BagEntry& a, const BagEntry& b) {
    return std::tie(a.log_time, a.chunk, a.offset) <
           std::tie(b.log_time, b.chunk, b.offset);
  });
}

RecordingStatus
BagReader::fail(std::size_t file, std::uint64_t offset, const std::string& message)
{
  const std::string& path = files_[file].bag_file->file().path();
  const bool has_rows = files_[file].bag_file->hasRows(); // in place of bytes
  if (known_damage_.emplace(file, offset).second)
    damage_.push_back({has_rows ? 0 : offset, message, path});
  return {RecordingCode::Damaged,
          "'" + path + "', " +
              (has_rows ? "" : "byte " + std::to_string(offset) + ": ") + message};
}

RecordingStatus
BagReader::read(const BagEntry& entry, McapMessage& message)
{
  return guarded([&]() -> RecordingStatus {
    const FileSection& part = sections_[entry.chunk];
    if (entry.log_time < last_time_)
      cache_->beginPass();
    last_time_ = entry.log_time;
    std::uint16_t channel_id = 0;
    std::string failure = openFile(part.file).read(
        {part.section, entry.chunk, entry.offset}, message, channel_id);
    if (failure.empty()) {
      const auto& channels = files_[part.file].channels;
      const auto channel = channels.find(channel_id);
      if (channel == channels.end() || channel->second != entry.channel ||
          message.log_time != entry.log_time)
        failure = not_indexed;
    }
    message.channel = entry.channel;
    if (failure.empty())
      failure = decompressMessage(channels_[entry.channel], message.bytes);
    return failure.empty() ? RecordingStatus()
                           : fail(part.file, placeOf(entry), failure);
  });
}

RecordingStatus
BagReader::readMetadata(std::vector<McapMetadata>& metadata)
{
  return guarded([&]() -> RecordingStatus {
    metadata.clear();
    RecordingStatus status;
    for (std::size_t i = 0; i < files_.size(); ++i)
      for (const mcap::RecordExtent& extent : files_[i].metadata) {
        McapMetadata read;
        if (openFile(i).readMetadata(extent, read))
          metadata.push_back(std::move(read));
        else
          status = fail(i, extent.offset, "a metadata record cannot be read");
      }
    return status;
  });
}

RecordingStatus
BagReader::readAttachments(
    const std::function<RecordingStatus(const McapAttachment&)>& visit)
{
  return guarded([&]() -> RecordingStatus {
    RecordingStatus status;
    for (std::size_t i = 0; i < files_.size(); ++i)
      for (const mcap::RecordExtent& extent : files_[i].attachments) {
        McapAttachment attachment;
        if (!openFile(i).readAttachment(extent, attachment))
          status = fail(i, extent.offset, "an attachment cannot be read");
        else if (RecordingStatus visited = visit(attachment); !visited.ok())
          return visited;
      }
    return status;
  });
}

RecordingStatus
BagReader::open(const std::string& path, const ChannelFilter& wants)
{
  return guarded([&] {
    *this = BagReader();
    return openPath(path, wants);
  });
}

RecordingStatus
BagReader::open(InputFile&& file, const ChannelFilter& wants)
{
  return guarded([&] {
    *this = BagReader();
    RecordingStatus status = addFile(std::move(file), wants);
    sortIndex();
    return status;
  });
}

bool
BagReader::isBag(const std::string& path)
{
  if (isRosbag2Folder(path))
    return true;
  InputFile file;
  return path != standard_stream && file.open(path).ok() && isBagFile(file);
}

bool
BagReader::isBagFile(const InputFile& file)
{
  if (mcap::isMcapFile(file))
    return true;
  const std::vector<std::uint8_t> beginning = beginningOf(file, sizeof(sqlite::magic));
  return beginsWith(beginning, sqlite::magic) || beginsWith(beginning, ros1::magic) ||
         beginsWith(beginning, "\x89MCAP");
}

/** \brief Byte of its file at which a message or its chunk begins, or its row. */
std::uint64_t
BagReader::placeOf(const BagEntry& entry) const
{
  const Section& section = sections_[entry.chunk].section;
  return section.is_chunk ? section.offset : entry.offset;
}

std::uint64_t
BagReader::fileOffset(const BagEntry& entry) const
{
  // In a database it is in pages.
  const bool has_rows = files_[sections_[entry.chunk].file].bag_file->hasRows();
  return has_rows ? 0 : placeOf(entry);
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
