// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_status.h>

#include "recording/bag_contents.h"
#include "recording/files.h"

namespace pcl_ext::PCL_EXT_ABI::recording::mcap {

/** \brief True if a file has the magic bytes of MCAP at its beginning or, if these are
 * damaged, at its end. */
bool
isMcapFile(const InputFile& file);

/** \brief Finds the contents of a file: by its summary, and if that is missing or does
 * not tell of all messages, by reading all of the file.
 * \param[in] file the file
 * \param[in] wants channels whose messages are wanted; empty: all
 * \param[out] contents also of a damaged file
 * \return NotARecording if it is no MCAP file
 */
RecordingStatus
findContents(const InputFile& file, const ChannelFilter& wants, FileContents& contents);

} // namespace pcl_ext::PCL_EXT_ABI::recording::mcap
