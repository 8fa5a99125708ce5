// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/bag_file.h"
#include "recording/chunk_cache.h"
#include "recording/ros1/connections.h"

#include <string>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording::ros1 {

class Ros1File : public BagFile {
public:
  /** \param[in] cache of the bag; must outlive this */
  Ros1File(InputFile&& file, ChunkCache& cache)
  : BagFile(std::move(file)), cache_(cache)
  {}

  /** \brief Reads the indexes of the chunks, and the connections at the end of the file;
   * where those are missing, as of a bag that was cut off, chunks are read. NotARecording
   * also of other versions than 2.0, and of encrypted bags. */
  RecordingStatus
  findContents(const ChannelFilter& wants, FileContents& contents) override;

  std::string
  read(const MessagePlace& place,
       McapMessage& message,
       std::uint16_t& channel_id) override;

private:
  std::string
  takeMessage(const Fields& fields,
              McapMessage& message,
              std::uint16_t& channel_id) const;

  ChunkCache& cache_;
  Connections connections_;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording::ros1
