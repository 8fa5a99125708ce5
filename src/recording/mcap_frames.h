// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/bag_reader.h"
#include "recording/frame_source.h"
#include "recording/point_cloud_messages.h"

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief The frames in the messages of an MCAP file or a rosbag2 folder. */
class McapFrames : public FrameSource {
public:
  /** \brief Finds the frames of an open file, whose compressed clouds are indexed.
   * \return NotARecording if there are none of this library
   */
  RecordingStatus
  open(BagReader reader, const std::string& path);

  RecordingStatus
  read(const IndexedFrame& indexed, RecordedFrame& frame) override;

  const std::vector<RecordingDamage>&
  damage() const override
  {
    return reader_.damage();
  }

  bool
  isUnfinished() const override
  {
    return reader_.isUnfinished();
  }

  std::uint64_t
  fileBytes() const override
  {
    return reader_.fileBytes();
  }

private:
  RecordingStatus
  readCloud();

  std::vector<std::string>
  formatsOfChannels();

  void
  addFrames(const std::vector<std::size_t>& streams);

  RecordingStatus
  nothingFound(const std::string& path, const std::vector<std::string>& formats) const;

  BagReader reader_;
  McapMessage message_;
  PointCloudMessage cloud_;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
