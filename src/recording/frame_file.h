// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_decoder.h>

#include "recording/frame_source.h"

#include <optional>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief A file of the frames of one stream, one after the other. Bytes that are no
 * frames are skipped, as a decoder does. */
class FrameFile : public FrameSource {
public:
  /** \brief Finds the frames of a file.
   * \param[in] file the file
   * \return NotARecording if there is none
   */
  RecordingStatus
  open(InputFile file);

  RecordingStatus
  read(const IndexedFrame& indexed, RecordedFrame& frame) override;

  const std::vector<RecordingDamage>&
  damage() const override
  {
    return damage_;
  }

  bool
  isUnfinished() const override
  {
    return is_cut_off_;
  }

  std::uint64_t
  fileBytes() const override
  {
    return file_.size();
  }

private:
  struct StoredFrame {
    std::uint64_t offset;
    std::uint64_t size;
    Time stamp;
    std::string frame_id;
  };

  bool
  readBytes(std::uint64_t offset, std::size_t count, std::uint8_t* bytes) const;

  io::FrameSize
  sizeAt(std::uint64_t offset);

  void
  addFrameAt(std::uint64_t offset, std::uint64_t size);

  std::uint64_t
  takeFrame(std::uint64_t offset, std::uint64_t size);

  std::uint64_t
  skipBytes(std::uint64_t offset, const std::string& reason);

  bool
  mayBeginAt(std::uint64_t offset);

  std::uint64_t
  findFrame(std::uint64_t offset);

  void
  addDamage(std::uint64_t offset, const std::string& message)
  {
    damage_.push_back({offset, message, file_.path()});
  }

  InputFile file_;
  std::vector<StoredFrame> stored_frames_;
  std::vector<IndexedFrame> found_frames_; // until the file is open
  std::vector<RecordingDamage> damage_;
  bool is_cut_off_ = false;
  std::optional<std::uint64_t> stamp_; // of the last frame that had one, microseconds
  bool knows_stamps_ = false;
  std::uint32_t last_number_ = 0; // of a frame
  std::string frame_id_;          // of the last frame
  std::vector<std::uint8_t> bytes_;
  std::vector<std::uint8_t> block_; // in which frames are searched for
  std::uint64_t block_offset_ = 0;
  std::uint64_t skipped_end_ = 0; // after the last bytes that were no frame
  std::string skip_reason_;
  std::uint64_t reread_ = 0; // bytes of frames whose size was not found
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
