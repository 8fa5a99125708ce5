// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Headers of a message with a frame, besides which it has the frame's bytes alone.
 */
#pragma once

#include <pcl_ext/link/link_settings.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::link {

/** \brief Name of the header with a FrameHeader. */
constexpr char frame_header[] = "Pcl-Ext-Frame";

/** \brief Name of the headers with a StreamMetadata, one for each pair. */
constexpr char metadata_header[] = "Pcl-Ext-Metadata";

/** \brief What goes with each frame. */
struct FrameHeader {
  std::uint64_t publisher = 0; ///< random number of this run of the publisher
  std::uint64_t number = 0;    ///< of the frame in its stream, from 1; lost ones count
  Time time{0};                ///< of the cloud
};

/** \brief Writes "1 PUBLISHER NUMBER TIME": the version of the headers, hexadecimal and
 * two decimal numbers. */
std::string
writeFrameHeader(const FrameHeader& header);

/** \brief Reads a header of the version that this library writes; nothing if it is
 * none. */
std::optional<FrameHeader>
parseFrameHeader(std::string_view text);

/** \brief Writes KEY=VALUE, both escaped. */
std::string
writeMetadata(const std::string& key, const std::string& value);

/** \brief Reads a key and its value; nothing if it is none. */
std::optional<std::pair<std::string, std::string>>
parseMetadata(std::string_view text);

} // namespace pcl_ext::PCL_EXT_ABI::link
