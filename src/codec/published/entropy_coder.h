#pragma once

#include "bytes/byte_source.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace published {

/** \brief Appends bytes, coded as pcl::StaticRangeCoder::encodeCharVectorToStream codes
 * them: 257 cumulative frequencies of four bytes, then a carryless range coder's
 * output.
 *
 * Written here because PCL's decoder believes all that it reads, and because it would
 * pull in PCL's io module. The bytes are the same.
 */
void
encodeStaticRange(const std::vector<std::uint8_t>& symbols,
                  std::vector<std::uint8_t>& bytes);

/** \brief Reads back what encodeStaticRange, or PCL, wrote.
 *
 * PCL writes no checksum; what stands in for it is redundancy: the table must be the
 * one that an encoder derives from these very symbols, and the last four bytes must be
 * the end of the range. A count that contradicts the table is refused before any symbol
 * is decoded.
 * \param[in,out] source where to read; its failure() tells if the bytes ended
 * \param[in] count number of symbols, checked by the caller against its limits
 * \param[out] symbols the symbols
 * \return false if the bytes are not the work of an encoder, or ended
 */
bool
decodeStaticRange(ByteSource& source,
                  std::size_t count,
                  std::vector<std::uint8_t>& symbols);

} // namespace published
} // namespace io
} // namespace pcl_ext
