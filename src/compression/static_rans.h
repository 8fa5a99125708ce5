#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Appends a row of byte symbols, coded with one static order-0 table, or as
 * they are where that is smaller (doc/bitstream.md, "Symbol rows").
 *
 * The entropy coder is a range variant of asymmetric numeral systems (rANS; J. Duda,
 * arXiv:1311.2540, 2013): 32-bit states, 16 bits renormalised at a time.
 * \param[in] symbols the row; its length is not written
 * \param[in,out] bytes where to append
 */
void
encodeSymbols(const std::vector<std::uint8_t>& symbols,
              std::vector<std::uint8_t>& bytes);

/** \brief Reads back what encodeSymbols wrote.
 * \param[in,out] cursor first byte of the row; moved behind the row
 * \param[in] end end of the readable bytes
 * \param[in] count length of the row; the caller has checked it against its limits
 * \param[out] symbols the row
 * \return false if the bytes are not a row of that length
 */
bool
decodeSymbols(const std::uint8_t*& cursor,
              const std::uint8_t* end,
              std::size_t count,
              std::vector<std::uint8_t>& symbols);

/** \brief Bits that an order-0 coder needs for a row, its table not counted. */
double
orderZeroBits(const std::vector<std::uint8_t>& symbols);

} // namespace io
} // namespace pcl_ext
