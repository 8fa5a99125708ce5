// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/bag_file.h"
#include "recording/chunk_cache.h"

#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording::mcap {

/** \brief True if a file has the magic bytes of MCAP at its beginning or, if these are
 * damaged, at its end. */
bool
isMcapFile(const InputFile& file);

/** \brief An MCAP file. */
class McapFile : public BagFile {
public:
  /** \param[in] cache of the bag; must outlive this */
  McapFile(InputFile&& file, ChunkCache& cache)
  : BagFile(std::move(file)), cache_(cache)
  {}

  /** \brief Finds channels and messages by the summary or, without one or if it does not
   * tell of all messages, by reading all of the file. */
  RecordingStatus
  findContents(const ChannelFilter& wants, FileContents& contents) override;

  std::string
  read(const MessagePlace& place,
       McapMessage& message,
       std::uint16_t& channel_id) override;

  bool
  readMetadata(const RecordExtent& extent, McapMetadata& metadata) override;

  bool
  readAttachment(const RecordExtent& extent, McapAttachment& attachment) override;

private:
  ChunkCache& cache_;
  std::vector<std::uint8_t> record_;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording::mcap
