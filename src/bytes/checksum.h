#pragma once

#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief CRC-32 (ISO-HDLC) over a checksum and bytes, which makes chains of frames.
 * \param[in] reference_checksum comes first, as four bytes little-endian
 * \param[in] bytes follow it; may be null if there are none
 * \param[in] size their number
 */
std::uint32_t
chainedChecksum(std::uint32_t reference_checksum,
                const std::uint8_t* bytes,
                std::size_t size);

} // namespace io
} // namespace pcl_ext
