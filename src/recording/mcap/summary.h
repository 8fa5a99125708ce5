// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/files.h"
#include "recording/mcap/channel_list.h"
#include "recording/mcap/record_access.h"
#include "recording/mcap/records.h"

#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording::mcap {

/** \brief What the summary of a file tells besides its channels. */
struct Summary {
  std::vector<ChunkIndex> chunks;
  std::vector<RecordExtent> attachments;
  std::vector<RecordExtent> metadata;
  Statistics statistics;
};

/** \brief Reads the summary at the end of a complete file.
 * \param[in] file for which hasMcapEnd() is true
 * \param[in,out] channels those of the summary are added
 * \param[out] summary the rest of it
 * \return false if there is none, it is damaged, or it does not tell of all contents
 */
bool
readSummary(const InputFile& file, ChannelList& channels, Summary& summary);

} // namespace pcl_ext::PCL_EXT_ABI::recording::mcap
