#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_encoder.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/status.h>

#include "bytes/byte_source.h"

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
  bool has_depth_model = false; // the payload begins with one
  Effort effort = Effort::Balanced;
  std::uint32_t frame_number = 0;    // a P-frame depends on the frame before it
  VoxelGrid grid;                    // I only
  IntensityScale intensity_scale;    // I only
  std::optional<std::int64_t> stamp; // P: change since the frame before it
  bool has_frame_id = false;         // P: only if it changed
  std::string frame_id;              // empty without
  std::uint64_t voxel_count = 0;
  std::uint64_t payload_size = 0; // bytes
};

/** \brief Bytes of a depth model in front of a payload. */
constexpr std::size_t depth_model_size = 25;

/** \brief Appends a depth model as a payload begins with it. */
void
writeDepthModel(const DepthModel& model, std::vector<std::uint8_t>& payload);

/** \brief Reads a depth model.
 * \param[in] bytes depth_model_size bytes
 * \param[out] model the model
 * \return false if there can be no such model
 */
bool
readDepthModel(const std::uint8_t* bytes, DepthModel& model);

/** \brief Writes a whole frame: header, payload, and over both the checksum.
 * \param[in] header its size is the payload's
 * \param[in] payload what follows the header
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
