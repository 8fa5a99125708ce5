// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/bag_contents.h"
#include "recording/files.h"
#include "recording/ros1/connections.h"

namespace pcl_ext::PCL_EXT_ABI::recording::ros1 {

/** \brief Finds the contents of a bag of ROS 1: by the indexes behind its chunks and the
 * connections at its end; where those are missing, as of a bag that was cut off, chunks
 * are read.
 * \param[in] wants channels whose messages are wanted; empty: all
 * \param[out] connections of the bag
 * \return NotARecording if it is none of version 2.0, or encrypted
 */
RecordingStatus
findContents(const InputFile& file,
             const ChannelFilter& wants,
             Connections& connections,
             FileContents& contents);

} // namespace pcl_ext::PCL_EXT_ABI::recording::ros1
