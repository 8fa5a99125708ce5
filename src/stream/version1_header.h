// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/status.h>

#include "bytes/byte_source.h"
#include "codec/frame_limits.h"
#include "codec/supplement/content.h"
#include "stream/scan_table.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The four bytes that every frame of stream version 1 begins with; the version
 * follows them. */
constexpr char version1_magic[] = "PCXI";
constexpr std::size_t version1_magic_size = sizeof(version1_magic) - 1;

/** \brief Longest frame_id that a frame carries, bytes. */
constexpr std::size_t max_frame_id_size = 1024;

/** \brief Frame header of stream version 1, field by field as in doc/bitstream.md. */
struct Version1Header {
  bool is_i_frame = true;
  bool is_of_changes = false;   // P only
  bool has_depth_model = false; // at the beginning of the payload
  Effort effort = Effort::Balanced;
  std::uint32_t frame_number = 0;          // a P-frame depends on the frame before it
  VoxelGrid grid;                          // I only
  IntensityScale intensity_scale;          // I only; bits 0: no intensities
  supplement::Content content;             // P: without the colour bits
  std::vector<FieldDescription> fields;    // I only
  std::array<std::int32_t, 3> viewpoint{}; // I only; see VoxelFrame
  scan::ScanLayout scan;                   // I only
  std::shared_ptr<const MessageLayout> layout; // I only; null: none
  std::optional<ScanPlacement> placement; // P only; of a scan, another one than before
  std::optional<DepthModel> depth_model;  // of the payload, or that of before
  std::optional<std::int64_t> stamp;      // P: difference to the previous frame
  bool has_frame_id = false;              // P: only if it has changed
  std::string frame_id;                   // empty if absent
  std::uint64_t voxel_count = 0;
  std::uint64_t payload_size = 0; // bytes, those of supplement and padding included
  // Depend on the content:
  std::uint64_t coarse_voxel_count = 0;
  std::uint64_t point_count = 0;
  std::uint64_t supplement_size = 0; // bytes
  std::uint64_t padding_size = 0;    // bytes of 0 at the end of the payload; I only
};

/** \brief Whether bytes begin as a frame of changes, without a check of the rest. */
PCL_EXT_CODEC_EXPORT bool
beginsFrameOfChanges(const std::uint8_t* bytes, std::size_t size);

/** \brief Size of a depth model in the payload, bytes. */
constexpr std::size_t depth_model_size = 25;

/** \brief Appends a depth model to a payload. */
void
writeDepthModel(const DepthModel& model, std::vector<std::uint8_t>& payload);

/** \brief Reads a depth model.
 * \param[in] bytes depth_model_size bytes
 * \param[out] model the model
 * \return false if the model is invalid
 */
bool
readDepthModel(const std::uint8_t* bytes, DepthModel& model);

/** \brief Writes a complete frame: header, payload and the checksum of both.
 * \param[in] header with the size of the payload
 * \param[in] payload the bytes after the header
 * \param[in] reference_checksum checksum of the frame that this one depends on, 0 for
 * an I-frame; not written, but included in the checksum, so that a P-frame is not
 * accepted as the successor of another frame of the same number
 * \param[in,out] bytes the frame is appended
 * \return the frame's checksum
 */
std::uint32_t
writeVersion1Frame(const Version1Header& header,
                   const std::vector<std::uint8_t>& payload,
                   std::uint32_t reference_checksum,
                   std::vector<std::uint8_t>& bytes);

/** \brief The checksum in the header of a frame.
 * \param[in] bytes a frame of stream version 1, with all of its header
 */
std::uint32_t
version1ChecksumOf(const std::uint8_t* bytes);

/** \brief Whether the checksum in the header of a frame is that of its bytes.
 * \param[in] bytes exactly one frame of stream version 1
 * \param[in] size number of bytes
 * \param[in] reference_checksum as for writeVersion1Frame()
 */
bool
holdsVersion1Checksum(const std::uint8_t* bytes,
                      std::size_t size,
                      std::uint32_t reference_checksum);

/** \brief Number of values that a frame has of some fields. */
std::uint64_t
fieldValuesOf(const Version1Header& header,
              const std::vector<FieldDescription>& fields);

/** \brief Checks that a scan has not more pixels than a frame may have points. */
CompressionStatus
checkPixelCount(const scan::ScanLayout& layout, const FrameLimits& limits);

/** \brief The limits of a frame by its bytes.
 * \param[in] header of the frame
 * \param[in] bytes_before payloads of the frames since the last I-frame
 */
FrameLimits
limitsOf(const Version1Header& header,
         const DecoderLimits& limits,
         std::uint64_t bytes_before);

/** \brief Where the frames before a P-frame are not known: they may have any number. */
constexpr std::uint64_t any_bytes_before = std::uint64_t{1} << 40;

/** \brief Reads and checks a frame header after the magic bytes.
 * \param[in,out] source after the magic bytes
 * \param[in] limits bounds on time and memory
 * \param[out] header the fields
 * \param[out] checksum the checksum in the header
 * \param[out] checked_bytes all bytes of the header after the checksum
 * \param[in] bytes_before see limitsOf()
 */
CompressionStatus
readVersion1Header(ByteSource& source,
                   const DecoderLimits& limits,
                   Version1Header& header,
                   std::uint32_t& checksum,
                   std::vector<std::uint8_t>& checked_bytes,
                   std::uint64_t bytes_before = any_bytes_before);

} // namespace pcl_ext::PCL_EXT_ABI::io
