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
 * Not PCL's own coder, which does not check what it reads, and needs PCL's io module. The
 * bytes are the same.
 */
void
encodeStaticRange(const std::vector<std::uint8_t>& symbols,
                  std::vector<std::uint8_t>& bytes);

/** \brief Reads back what encodeStaticRange, or PCL, wrote.
 *
 * PCL writes no checksum. Instead the redundancy is checked: the table must be the one
 * that an encoder derives from these symbols, and the last four bytes must be the end of
 * the range. A count that contradicts the table is refused before any symbol is decoded.
 * \param[in,out] source where to read; its failure() tells if the bytes ended
 * \param[in] count number of symbols, checked by the caller against its limits
 * \param[out] symbols the symbols
 * \return false if no encoder writes these bytes, or they ended
 */
bool
decodeStaticRange(ByteSource& source,
                  std::size_t count,
                  std::vector<std::uint8_t>& symbols);

} // namespace published
} // namespace io
} // namespace pcl_ext
