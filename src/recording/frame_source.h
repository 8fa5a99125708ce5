// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_reader.h>

#include "recording/files.h"
#include "recording/recording_limits.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief A frame of a recording, without its bytes. */
struct IndexedFrame {
  Time time{0};           // orders the frames
  std::size_t stream = 0; // index in the streams
  std::size_t number = 0; // of the frame in its stream
  std::uint64_t at = 0;   // for the source
};

/** \brief The frames of a recording, by the kind of its file. */
class FrameSource {
public:
  virtual ~FrameSource() = default;

  /** \brief Reads the bytes of a frame, with its times, its frame_id and its offset.
   * The description follows from the bytes. */
  virtual RecordingStatus
  read(const IndexedFrame& indexed, RecordedFrame& frame) = 0;

  virtual const std::vector<RecordingDamage>&
  damage() const = 0;

  virtual bool
  isUnfinished() const = 0;

  virtual std::uint64_t
  fileBytes() const = 0;

  const std::vector<RecordedStream>&
  streams() const
  {
    return streams_;
  }

  /** \brief All frames in the order of their times. */
  const std::vector<IndexedFrame>&
  frames() const
  {
    return frames_;
  }

protected:
  /** \brief Gives frames that seem to be before an earlier one of their stream its time,
   * as after the clock was set back. A single frame that is after the next one, which is
   * not before the frame in front of it, gets the time of the next one instead: a byte of
   * its index is damaged. Of the first frame of a stream that is not known.
   * \param[in,out] frames in the order of the file
   */
  void
  makeTimesRise(std::vector<IndexedFrame>& frames) const;

  /** \brief Takes all frames at once, in the order of their times; their numbers
   * follow. */
  void
  takeFrames(std::vector<IndexedFrame> frames);

  std::vector<RecordedStream> streams_;

private:
  void
  count(IndexedFrame& indexed);

  std::vector<IndexedFrame> frames_;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
