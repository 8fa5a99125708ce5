#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/compression_status.h>
#include <pcl_ext/compression/frame_encoder.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "byte_source.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief The four bytes that every frame of this library's own streams begins with;
 * the version follows them. */
constexpr char version1_magic[] = "PCXI";
constexpr std::size_t version1_magic_size = sizeof(version1_magic) - 1;

/** \brief Longest frame_id that a frame carries, bytes. */
constexpr std::size_t max_frame_id_size = 1024;

/** \brief Frame header of stream version 1, field by field as in doc/bitstream.md. */
struct Version1Header {
  bool is_i_frame = true;
  std::uint32_t frame_number = 0;
  std::uint8_t reference_distance = 0; // P: depends on frame_number - this; I: 0
  VoxelGrid grid;                      // on the wire in I-frames only
  std::optional<IntensityScale> intensity_scale; // P: only if it changed
  std::optional<std::uint64_t> stamp;
  std::optional<std::string> frame_id; // P: only if it changed
  std::uint64_t voxel_count = 0;
  std::uint64_t occupancy_size = 0; // bytes
  std::uint64_t intensity_size = 0; // bytes
};

/** \brief Writes a whole frame: header, payload, and over both the checksum.
 * \param[in] header the sizes in it are those of the payload
 * \param[in] payload occupancy, then intensities
 * \param[in] reference_checksum checksum of the frame that this one depends on, 0 for
 * an I-frame; not written, but part of the checksum, so that a P-frame cannot pass for
 * the successor of another stream's frame of the same number
 * \param[in,out] bytes where to append
 * \return the frame's checksum
 */
std::uint32_t
writeVersion1Frame(const Version1Header& header,
                   const std::vector<std::uint8_t>& payload,
                   std::uint32_t reference_checksum,
                   std::vector<std::uint8_t>& bytes);

/** \brief Reads and checks a frame header, of which the magic bytes have been read.
 * \param[in,out] source behind the magic bytes; records what it reads
 * \param[in] limits what decoding may cost
 * \param[out] header the fields
 * \param[out] checksum the frame's checksum as written
 * \param[out] checked_bytes every byte that was read behind the checksum
 */
CompressionStatus
readVersion1Header(ByteSource& source,
                   const DecoderLimits& limits,
                   Version1Header& header,
                   std::uint32_t& checksum,
                   std::vector<std::uint8_t>& checked_bytes);

/** \brief Checksum of a frame: CRC-32 (ISO-HDLC) over the reference's checksum, four
 * bytes little-endian, and all bytes of the frame behind its own checksum. */
std::uint32_t
version1Checksum(std::uint32_t reference_checksum,
                 const std::uint8_t* bytes,
                 std::size_t size);

} // namespace io
} // namespace pcl_ext
