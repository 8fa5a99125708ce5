// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/bag_contents.h"
#include "recording/files.h"

#include <string>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief What is wrong where no message is. */
constexpr char not_indexed[] = "a message is not where the index says";

/** \brief Where a message of a file is. */
struct MessagePlace {
  const Section& section;
  std::size_t section_number; // of all files of the bag, for caches
  std::uint64_t offset;       // see IndexedMessage
};

/** \brief A file of a bag; each format has a class of its own. Any bytes are safe. */
class BagFile {
public:
  explicit BagFile(InputFile&& file) : file_(std::move(file)) {}
  virtual ~BagFile() = default;
  BagFile(const BagFile&) = delete;
  BagFile&
  operator=(const BagFile&) = delete;

  /** \brief Finds channels and messages; called once.
   * \param[in] wants channels whose messages are wanted
   * \param[out] contents also of a damaged file
   * \return NotARecording if it is no file of this format
   */
  virtual RecordingStatus
  findContents(const ChannelFilter& wants, FileContents& contents) = 0;

  /** \brief Reads a message.
   * \param[in] place of an indexed message
   * \param[out] message its channel is not set; memory is reused
   * \param[out] channel_id of the contents
   * \return empty, or what is wrong
   */
  virtual std::string
  read(const MessagePlace& place, McapMessage& message, std::uint16_t& channel_id) = 0;

  /** \brief True if messages are in rows of a database: offsets are their numbers. */
  virtual bool
  hasRows() const
  {
    return false;
  }

  /** \brief Reads metadata of the contents; false if it cannot be read. */
  virtual bool
  readMetadata(const mcap::RecordExtent& /* extent */, McapMetadata& /* metadata */)
  {
    return false;
  }

  /** \brief Reads an attachment of the contents; false if it cannot be read. */
  virtual bool
  readAttachment(const mcap::RecordExtent& /* extent */,
                 McapAttachment& /* attachment */)
  {
    return false;
  }

  InputFile&
  file()
  {
    return file_;
  }

  const InputFile&
  file() const
  {
    return file_;
  }

private:
  InputFile file_;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
