// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::view {

/** \brief Bytes first to last of a file, both included. */
struct ByteRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;

  std::uint64_t
  size() const
  {
    return last - first + 1;
  }
};

/** \brief Ranges that one request may ask for; with more the header is ignored. */
constexpr std::size_t max_byte_ranges = 32;

/** \brief Parses a header Range (RFC 9110, section 14).
 * \param[in] header such as "bytes=0-99,-500"
 * \param[in] size of the file
 * \return nothing if the header is to be ignored: another unit, wrong, too many; empty
 * if none of the ranges is in the file
 */
std::optional<std::vector<ByteRange>>
parseByteRanges(std::string_view header, std::uint64_t size);

std::string
contentRange(const ByteRange& range, std::uint64_t size);

} // namespace pcl_ext::PCL_EXT_ABI::view
