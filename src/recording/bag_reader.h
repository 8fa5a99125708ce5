// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/recording/recording_status.h>

#include "recording/bag_contents.h"
#include "recording/mcap_content.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

class BagFile;
class ChunkCache;
class InputFile;

/** \brief Where a message is; see BagReader::index(). */
struct BagEntry {
  Time log_time{0};
  std::size_t channel = 0;  ///< index in BagReader::channels()
  std::size_t chunk = 0;    ///< place of the file in which it is
  std::uint64_t offset = 0; ///< in that place, when it is not compressed
};

/** \brief Reads MCAP files (version 0 of the format, https://mcap.dev/spec), files of
 * rosbag2's storage sqlite3, rosbag2 folders of either, and bags of ROS 1 (version 2.0).
 * Files and messages may be compressed with zstd, as rosbag2 does.
 *
 * Messages are found by the indexes of the file. A file without them, or one that was
 * cut off, is searched for messages once, when it is opened: all whole messages are
 * found, also in a chunk that is incomplete. A chunk whose checksum is wrong is left
 * out as a whole, and reported by damage(). Any bytes are safe; memory is bounded by
 * the file and by the limits on what is compressed, see mostChunkBytes().
 */
class PCL_EXT_RECORDING_EXPORT BagReader {
public:
  BagReader();
  ~BagReader();
  BagReader(BagReader&&) noexcept;
  BagReader&
  operator=(BagReader&&) noexcept;

  /** \brief Opens a file.
   * \param[in] path a file, a folder of the files of one bag, or - for the standard input
   * \param[in] wants channels to index; empty: all
   * \return Ok even if the file is damaged; see damage()
   */
  RecordingStatus
  open(const std::string& path, const ChannelFilter& wants = ChannelFilter());

  /** \brief True if a file begins as one of a bag, or is a rosbag2 folder. */
  static bool
  isBag(const std::string& path);

  /** \brief True if a file begins as MCAP files, databases of SQLite or bags of ROS 1
   * do, compressed or not. */
  static bool
  isBagFile(const InputFile& file);

  /** \brief Profile of the file, such as "ros2". */
  const std::string&
  profile() const
  {
    return profile_;
  }

  /** \brief All channels. Those of one topic are one channel if they agree in
   * everything and are in different files of a folder. */
  const std::vector<McapChannel>&
  channels() const
  {
    return channels_;
  }

  /** \brief The messages of the wanted channels, by their log time, those of the same
   * time in the order of the file. */
  const std::vector<BagEntry>&
  index() const
  {
    return index_;
  }

  /** \brief Reads a message.
   * \param[in] entry one of index()
   * \param[out] message its memory is reused
   * \return Damaged if the message cannot be read
   */
  RecordingStatus
  read(const BagEntry& entry, McapMessage& message);

  /** \brief Reads all metadata records. */
  RecordingStatus
  readMetadata(std::vector<McapMetadata>& metadata);

  /** \brief Reads the attachments one after the other.
   * \param[in] visit called for each
   */
  RecordingStatus
  readAttachments(const std::function<RecordingStatus(const McapAttachment&)>& visit);

  /** \brief Byte of its file at which the message or its chunk begins. */
  std::uint64_t
  fileOffset(const BagEntry& entry) const;

  /** \brief What could not be read until now. */
  const std::vector<RecordingDamage>&
  damage() const
  {
    return damage_;
  }

  /** \brief True if a file had no summary, as one whose recorder did not end in an
   * orderly way. */
  bool
  isUnfinished() const
  {
    return is_unfinished_;
  }

  /** \brief True if a file was decompressed into a temporary one, as it is whenever it
   * is opened. */
  bool
  isCompressed() const
  {
    return is_compressed_;
  }

  /** \brief True if a file has the storage sqlite3. */
  bool
  hasDatabases() const
  {
    return has_databases_;
  }

  std::uint64_t
  fileBytes() const
  {
    return file_bytes_;
  }

private:
  friend class RecordingReader;

  /** \brief A file of the bag, with its contents among those of the bag. */
  struct IndexedFile;

  /** \brief A section of one of several files. */
  struct FileSection {
    std::size_t file;
    Section section;
  };

  RecordingStatus
  open(InputFile&& file, const ChannelFilter& wants);

  RecordingStatus
  openPath(const std::string& path, const ChannelFilter& wants);

  RecordingStatus
  addFile(InputFile&& file, const ChannelFilter& wants);

  std::unique_ptr<BagFile>
  bagFileOf(InputFile&& file);

  void
  addChannels(std::map<std::uint16_t, McapChannel>& channels, IndexedFile& file);

  void
  sortIndex();

  RecordingStatus
  fail(std::size_t file, std::uint64_t offset, const std::string& message);

  BagFile&
  openFile(std::size_t number);

  std::uint64_t
  placeOf(const BagEntry& entry) const;

  std::string profile_;
  std::vector<McapChannel> channels_;
  std::vector<BagEntry> index_;
  std::vector<FileSection> sections_;
  std::vector<RecordingDamage> damage_;
  bool is_unfinished_ = false;
  bool is_compressed_ = false;
  bool has_databases_ = false;
  std::uint64_t file_bytes_ = 0;
  std::unique_ptr<ChunkCache> cache_; // of all files
  Time last_time_{0};                 // of the message that was read last
  std::vector<IndexedFile> files_;
  std::vector<std::size_t> open_files_; // numbers; the one used last is the last
  std::set<std::pair<std::size_t, std::uint64_t>> known_damage_; // file and offset
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
