// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/recording/recording_status.h>

#include "recording/mcap_content.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief Reads an MCAP file from its beginning to its end, while it is written: from a
 * pipe. Messages come in the order of the file; neither indexes nor a summary are
 * needed.
 *
 * It is exported for the program pcl_ext. Any bytes are safe; memory is that of one
 * record, at most max_record_bytes, its chunk, see mostChunkBytes(), and of the channels.
 */
class PCL_EXT_RECORDING_EXPORT McapStream {
public:
  /** \brief Reads up to a number of bytes, and waits for the first; 0 at the end. */
  using ReadSome = std::function<std::size_t(std::uint8_t* bytes, std::size_t count)>;

  /** \brief What next() found. */
  enum class Found { Message, Metadata, Attachment, End };

  /** \param[in] read the file, from after its first 8 bytes, which tell its kind
   * \param[in] name of the input, for damage()
   */
  McapStream(ReadSome read, std::string name);
  ~McapStream();
  McapStream(const McapStream&) = delete;
  McapStream&
  operator=(const McapStream&) = delete;

  /** \brief Reads up to the next content, which has then been read. */
  Found
  next();

  /** \brief Profile of the file; after the first next(). */
  const std::string&
  profile() const;

  /** \brief All channels until now. */
  const std::vector<McapChannel>&
  channels() const;

  /** \brief What next() found last. */
  McapMessage&
  message();
  const McapMetadata&
  metadata() const;
  const McapAttachment&
  attachment() const;

  /** \brief What could not be read until now. */
  const std::vector<RecordingDamage>&
  damage() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
