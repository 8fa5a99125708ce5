// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

/** \file
 * What rosbag2 compresses with zstd: files of a bag, or each message by itself.
 */
#include <pcl_ext/recording/recording_status.h>

#include "recording/files.h"
#include "recording/mcap_content.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief True if a file begins as those of zstd do. */
bool
isZstd(const InputFile& file);

/** \brief Replaces the bytes of a compressed file by a temporary copy without
 * compression, whose size is bounded by that of the file, or 1 GiB.
 * \param[in,out] file its path stays
 * \param[out] damage what is wrong with the compressed bytes; those before are there
 */
RecordingStatus
decompressFile(InputFile& file, std::string& damage);

/** \brief The first bytes of a file, without its compression; fewer if it has not as
 * many. */
std::vector<std::uint8_t>
beginningOf(const InputFile& file, std::size_t count);

/** \brief Decompresses a message that was compressed by itself; others stay as they are.
 * They are told apart by their first bytes, as metadata.yaml, which names the mode, may
 * be missing.
 * \return empty, or what is wrong
 */
std::string
decompressMessage(const McapChannel& channel, std::vector<std::uint8_t>& bytes);

} // namespace pcl_ext::PCL_EXT_ABI::recording
