// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "bytes/byte_source.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace published {

/** \brief Encodes symbols as pcl::StaticRangeCoder::encodeCharVectorToStream does: 257
 * cumulative frequencies of four bytes, then the output of a carryless range coder.
 *
 * PCL's coder writes the same bytes, but does not check what it reads, and needs PCL's
 * io module.
 * \param[in] symbols any number of them, which is not coded
 * \param[in,out] bytes where to append
 */
void
encodeStaticRange(const std::vector<std::uint8_t>& symbols,
                  std::vector<std::uint8_t>& bytes);

/** \brief Inverse of encodeStaticRange.
 *
 * The layout has no checksum, but redundancy, which is checked: the frequencies have to
 * be those of the decoded symbols, and the last four bytes the end of the range. A
 * count that does not fit the frequencies is refused before any symbol is decoded.
 * \param[in,out] source where to read; after false its failure() distinguishes too few
 * bytes from invalid ones
 * \param[in] count number of symbols, within the caller's limits
 * \param[out] symbols the symbols
 * \return false if there are too few bytes, or an encoder does not write them
 */
bool
decodeStaticRange(ByteSource& source,
                  std::size_t count,
                  std::vector<std::uint8_t>& symbols);

} // namespace published
} // namespace pcl_ext::PCL_EXT_ABI::io
