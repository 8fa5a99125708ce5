// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/mcap_reader.h"

#include "recording/compressed_input.h"
#include "recording/files.h"
#include "recording/guarded.h"
#include "recording/mcap/chunk_cache.h"
#include "recording/mcap/file_contents.h"
#include "recording/rosbag2_folder.h"
#include "recording/span_reader.h"
#include "recording/sqlite/bag_database.h"

#include <algorithm>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <system_error>
#include <tuple>
#include <utility>

namespace pcl_ext {
namespace recording {

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

/** \brief A section of one of several files. */
struct FileSection {
  std::size_t file;
  mcap::Section section;
};

bool
isFolder(const std::string& path)
{
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

/** \brief A file of a bag. */
struct BagFile {
  InputFile file;
  std::unique_ptr<sqlite::BagDatabase> database; // null: it is an MCAP file
  std::map<std::uint16_t, std::size_t> channels; // index in all channels, by id
  std::vector<mcap::RecordExtent> metadata;
  std::vector<mcap::RecordExtent> attachments;
};

} // namespace

class McapReader::Implementation {
public:
  RecordingStatus
  open(const std::string& path, const ChannelFilter& wants);

  RecordingStatus
  addFile(InputFile file, const ChannelFilter& wants);

  void
  sortIndex();

  RecordingStatus
  read(const McapEntry& entry, McapMessage& message);

  RecordingStatus
  readMetadata(std::vector<McapMetadata>& metadata);

  RecordingStatus
  readAttachments(const std::function<RecordingStatus(const McapAttachment&)>& visit);

  bool
  isInDatabase(const McapEntry& entry) const
  {
    return files_[sections_[entry.chunk].file].database != nullptr;
  }

  std::string profile_;
  std::vector<McapChannel> channels_;
  std::vector<McapEntry> index_;
  std::vector<FileSection> sections_;
  std::vector<RecordingDamage> damage_;
  bool is_unfinished_ = false;
  bool is_compressed_ = false;
  bool has_databases_ = false;
  std::uint64_t file_bytes_ = 0;

private:
  RecordingStatus
  findContents(BagFile& bag_file,
               const ChannelFilter& wants,
               mcap::FileContents& contents);

  void
  addChannels(std::map<std::uint16_t, McapChannel>& channels, BagFile& bag_file);

  RecordingStatus
  readStored(const McapEntry& entry, McapMessage& message);

  RecordingStatus
  readRow(const McapEntry& entry, McapMessage& message);

  RecordingStatus
  readRecords(const std::vector<std::uint8_t>& records,
              const McapEntry& entry,
              McapMessage& message);

  RecordingStatus
  fail(std::size_t file, std::uint64_t offset, const std::string& message);

  const InputFile&
  openFile(std::size_t number);

  std::deque<BagFile> files_; // so that none moves
  std::vector<std::size_t>
      open_files_; // numbers of files; the one used last is the last
  std::set<std::pair<std::size_t, std::uint64_t>> known_damage_; // file and offset
  mcap::ChunkCache cache_;
  std::vector<std::uint8_t> record_;
};

void
McapReader::Implementation::addChannels(std::map<std::uint16_t, McapChannel>& channels,
                                        BagFile& bag_file)
{
  channels_.reserve(channels_.size() + channels.size()); // so that none moves below
  // Each continues at most one channel of this file: a topic may have several.
  std::multimap<decltype(identityOf(channels_.front())), std::size_t> earlier;
  for (std::size_t number = 0; number < channels_.size(); ++number)
    earlier.emplace(identityOf(channels_[number]), number);
  for (auto& [id, channel] : channels) {
    const auto same = earlier.lower_bound(identityOf(channel));
    if (same != earlier.end() && same->first == identityOf(channel)) {
      bag_file.channels[id] = same->second;
      earlier.erase(same);
      continue;
    }
    bag_file.channels[id] = channels_.size();
    channels_.push_back(std::move(channel));
  }
}

RecordingStatus
McapReader::Implementation::addFile(InputFile file, const ChannelFilter& wants)
{
  BagFile& bag_file = files_.emplace_back();
  const std::size_t number = files_.size() - 1;
  bag_file.file = std::move(file);
  file_bytes_ += bag_file.file.size();
  mcap::FileContents contents;
  if (RecordingStatus status = findContents(bag_file, wants, contents); !status.ok()) {
    file_bytes_ -= bag_file.file.size();
    files_.pop_back();
    return status;
  }
  if (number == 0)
    profile_ = contents.profile;
  addChannels(contents.channels, bag_file);
  const std::size_t first_section = sections_.size();
  for (const mcap::Section& section : contents.sections)
    sections_.push_back({number, section});
  index_.reserve(index_.size() + contents.messages.size());
  for (const mcap::IndexedMessage& message : contents.messages)
    index_.push_back({mcap::messageTime(message.log_time),
                      bag_file.channels[message.channel_id],
                      first_section + message.section,
                      message.offset});
  bag_file.metadata = std::move(contents.metadata);
  bag_file.attachments = std::move(contents.attachments);
  for (RecordingDamage& damage : contents.damage) {
    known_damage_.emplace(number, damage.offset);
    damage_.push_back(std::move(damage));
  }
  is_unfinished_ |= !contents.has_end;
  openFile(number);
  return {};
}

/** \brief Finds what a file has, whatever it is and whether it is compressed. */
RecordingStatus
McapReader::Implementation::findContents(BagFile& bag_file,
                                         const ChannelFilter& wants,
                                         mcap::FileContents& contents)
{
  if (isZstd(bag_file.file)) {
    is_compressed_ = true;
    std::string damage;
    if (RecordingStatus status = decompressFile(bag_file.file, damage); !status.ok())
      return status;
    if (!damage.empty())
      contents.damage.push_back({0, damage, bag_file.file.path()});
  }
  if (!sqlite::isDatabase(bag_file.file))
    return mcap::findContents(bag_file.file, wants, contents);
  has_databases_ = true;
  bag_file.database = std::make_unique<sqlite::BagDatabase>();
  return bag_file.database->open(bag_file.file, wants, contents);
}

/** \brief A file of the bag, which is opened if it is not open, in place of the one
 * that was not used for longest. */
const InputFile&
McapReader::Implementation::openFile(std::size_t number)
{
  const auto found = std::find(open_files_.begin(), open_files_.end(), number);
  if (found != open_files_.end())
    open_files_.erase(found);
  else if (open_files_.size() == max_open_files) {
    files_[open_files_.front()].file.suspend();
    open_files_.erase(open_files_.begin());
  }
  open_files_.push_back(number);
  files_[number].file.resume();
  return files_[number].file;
}

RecordingStatus
McapReader::Implementation::open(const std::string& path, const ChannelFilter& wants)
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
  }
  sortIndex();
  return files_.empty() ? first_failure : RecordingStatus();
}

void
McapReader::Implementation::sortIndex()
{
  // In place: a stable sort would take as much memory again.
  std::sort(index_.begin(), index_.end(), [](const McapEntry& a, const McapEntry& b) {
    return std::tie(a.log_time, a.chunk, a.offset) <
           std::tie(b.log_time, b.chunk, b.offset);
  });
}

RecordingStatus
McapReader::Implementation::fail(std::size_t file,
                                 std::uint64_t offset,
                                 const std::string& message)
{
  const std::string& path = files_[file].file.path();
  const bool has_rows = files_[file].database != nullptr; // in place of bytes
  if (known_damage_.emplace(file, offset).second)
    damage_.push_back({has_rows ? 0 : offset, message, path});
  return {RecordingCode::Damaged,
          "'" + path + "', " +
              (has_rows ? "" : "byte " + std::to_string(offset) + ": ") + message};
}

/** \brief Reads a message from uncompressed records, if it is the one that the index
 * says. */
RecordingStatus
McapReader::Implementation::readRecords(const std::vector<std::uint8_t>& records,
                                        const McapEntry& entry,
                                        McapMessage& message)
{
  const FileSection& part = sections_[entry.chunk];
  const std::uint64_t offset = part.section.is_chunk ? entry.offset : 0;
  mcap::MessagePrefix prefix;
  const std::size_t at_hand =
      offset < records.size() ? records.size() - static_cast<std::size_t>(offset) : 0;
  SpanReader reader(records.data() + (at_hand > 0 ? offset : 0), at_hand);
  const auto opcode = static_cast<mcap::Opcode>(reader.u8());
  const std::uint64_t length = reader.u64();
  const std::uint8_t* const content = reader.take(length);
  const BagFile& bag_file = files_[part.file];
  const auto channel =
      content != nullptr && opcode == mcap::Opcode::Message &&
              mcap::parse(content, static_cast<std::size_t>(length), prefix)
          ? bag_file.channels.find(prefix.channel_id)
          : bag_file.channels.end();
  if (channel == bag_file.channels.end() || channel->second != entry.channel ||
      mcap::messageTime(prefix.log_time) != entry.log_time)
    return fail(part.file,
                part.section.is_chunk ? part.section.offset : entry.offset,
                "a message is not where the index says");
  constexpr std::size_t fields_size =
      mcap::message_prefix_size - mcap::record_prefix_size;
  message.channel = entry.channel;
  message.sequence = prefix.sequence;
  message.log_time = mcap::messageTime(prefix.log_time);
  message.publish_time = mcap::messageTime(prefix.publish_time);
  message.bytes.assign(content + fields_size, content + length);
  return {};
}

RecordingStatus
McapReader::Implementation::read(const McapEntry& entry, McapMessage& message)
{
  if (RecordingStatus status = readStored(entry, message); !status.ok())
    return status;
  const std::string failure =
      decompressMessage(channels_[entry.channel], message.bytes);
  const FileSection& part = sections_[entry.chunk];
  return failure.empty()
             ? RecordingStatus()
             : fail(part.file,
                    part.section.is_chunk ? part.section.offset : entry.offset,
                    failure);
}

/** \brief Reads a message of a database, if it is the one that the index says. */
RecordingStatus
McapReader::Implementation::readRow(const McapEntry& entry, McapMessage& message)
{
  const std::size_t file = sections_[entry.chunk].file;
  BagFile& bag_file = files_[file];
  std::uint16_t channel_id = 0;
  std::string failure = bag_file.database->read(entry.offset, message, channel_id);
  if (failure.empty() && (bag_file.channels[channel_id] != entry.channel ||
                          message.log_time != entry.log_time))
    failure = "it is not what the index says";
  message.channel = entry.channel;
  return failure.empty()
             ? RecordingStatus()
             : fail(file,
                    entry.offset,
                    "message " + std::to_string(entry.offset) + ": " + failure);
}

RecordingStatus
McapReader::Implementation::readStored(const McapEntry& entry, McapMessage& message)
{
  const FileSection& part = sections_[entry.chunk];
  const InputFile& file = openFile(part.file);
  if (isInDatabase(entry))
    return readRow(entry, message);
  if (!part.section.is_chunk) {
    if (!mcap::readRecord(
            file, entry.offset, mcap::Opcode::Message, max_chunk_bytes, record_))
      return fail(part.file, entry.offset, "a message cannot be read");
    std::vector<std::uint8_t> prefix(mcap::record_prefix_size);
    file.read(entry.offset, prefix.size(), prefix.data());
    record_.insert(record_.begin(), prefix.begin(), prefix.end());
    return readRecords(record_, entry, message);
  }
  const mcap::ChunkCache::Records& records =
      cache_.records(file, part.section, entry.chunk);
  // What could be read of a chunk that was cut off is valid.
  if (!records.failure.empty() && !part.section.is_cut_off)
    return fail(part.file, part.section.offset, "a chunk: " + records.failure);
  if (!records.hasMessageAt(entry.offset))
    return fail(
        part.file, part.section.offset, "a message is not where the index says");
  return readRecords(records.bytes, entry, message);
}

RecordingStatus
McapReader::Implementation::readMetadata(std::vector<McapMetadata>& metadata)
{
  metadata.clear();
  RecordingStatus status;
  for (std::size_t i = 0; i < files_.size(); ++i)
    for (const mcap::RecordExtent& extent : files_[i].metadata) {
      McapMetadata read;
      if (mcap::readRecord(openFile(i),
                           extent.offset,
                           mcap::Opcode::Metadata,
                           max_chunk_bytes,
                           record_) &&
          mcap::parse(record_.data(), record_.size(), read))
        metadata.push_back(std::move(read));
      else
        status = fail(i, extent.offset, "a metadata record cannot be read");
    }
  return status;
}

RecordingStatus
McapReader::Implementation::readAttachments(
    const std::function<RecordingStatus(const McapAttachment&)>& visit)
{
  RecordingStatus status;
  for (std::size_t i = 0; i < files_.size(); ++i)
    for (const mcap::RecordExtent& extent : files_[i].attachments) {
      McapAttachment attachment;
      if (!mcap::readRecord(openFile(i),
                            extent.offset,
                            mcap::Opcode::Attachment,
                            max_attachment_bytes,
                            record_) ||
          !mcap::parse(record_.data(), record_.size(), attachment))
        status = fail(i, extent.offset, "an attachment cannot be read");
      else if (RecordingStatus visited = visit(attachment); !visited.ok())
        return visited;
    }
  return status;
}

McapReader::McapReader() : implementation_(new Implementation) {}
McapReader::~McapReader() = default;
McapReader::McapReader(McapReader&&) noexcept = default;
McapReader&
McapReader::operator=(McapReader&&) noexcept = default;

RecordingStatus
McapReader::open(const std::string& path, const ChannelFilter& wants)
{
  return guarded([&] {
    implementation_ = std::make_unique<Implementation>();
    return implementation_->open(path, wants);
  });
}

RecordingStatus
McapReader::open(InputFile&& file, const ChannelFilter& wants)
{
  return guarded([&] {
    implementation_ = std::make_unique<Implementation>();
    RecordingStatus status = implementation_->addFile(std::move(file), wants);
    implementation_->sortIndex();
    return status;
  });
}

bool
McapReader::isMcap(const std::string& path)
{
  if (isRosbag2Folder(path))
    return true;
  InputFile file;
  return path != standard_stream && file.open(path).ok() && isBagFile(file);
}

bool
McapReader::isBagFile(const InputFile& file)
{
  if (mcap::isMcapFile(file))
    return true;
  const std::vector<std::uint8_t> beginning = beginningOf(file, sizeof(sqlite::magic));
  const auto beginsWith = [&beginning](const char* text, std::size_t size) {
    return beginning.size() >= size &&
           std::equal(beginning.begin(),
                      beginning.begin() + static_cast<std::ptrdiff_t>(size),
                      reinterpret_cast<const std::uint8_t*>(text));
  };
  return beginsWith(sqlite::magic, sizeof(sqlite::magic)) || beginsWith("\x89MCAP", 5);
}

const std::string&
McapReader::profile() const
{
  return implementation_->profile_;
}

const std::vector<McapChannel>&
McapReader::channels() const
{
  return implementation_->channels_;
}

const std::vector<McapEntry>&
McapReader::index() const
{
  return implementation_->index_;
}

RecordingStatus
McapReader::read(const McapEntry& entry, McapMessage& message)
{
  return guarded([&] { return implementation_->read(entry, message); });
}

RecordingStatus
McapReader::readMetadata(std::vector<McapMetadata>& metadata)
{
  return guarded([&] { return implementation_->readMetadata(metadata); });
}

RecordingStatus
McapReader::readAttachments(
    const std::function<RecordingStatus(const McapAttachment&)>& visit)
{
  return guarded([&] { return implementation_->readAttachments(visit); });
}

std::uint64_t
McapReader::fileOffset(const McapEntry& entry) const
{
  const FileSection& part = implementation_->sections_[entry.chunk];
  if (implementation_->isInDatabase(entry))
    return 0; // it is in pages
  const mcap::Section& section = part.section;
  return section.is_chunk ? section.offset : entry.offset;
}

const std::vector<RecordingDamage>&
McapReader::damage() const
{
  return implementation_->damage_;
}

bool
McapReader::isCompressed() const
{
  return implementation_->is_compressed_;
}

bool
McapReader::hasDatabases() const
{
  return implementation_->has_databases_;
}

bool
McapReader::isUnfinished() const
{
  return implementation_->is_unfinished_;
}

std::uint64_t
McapReader::fileBytes() const
{
  return implementation_->file_bytes_;
}

} // namespace recording
} // namespace pcl_ext
