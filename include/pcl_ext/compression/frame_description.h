// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/status.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \addtogroup io
 * @{ */

/** \brief Bytes that hold the header of any frame: 8192, and 41 for each of the rows, of
 * which there are 65,536 at most, of the scan of a lidar. With 128 rows 13,440 bytes are
 * enough. */
constexpr std::size_t most_frame_header_bytes = 8192 + 41 * 65536;

/** \brief What the header of a frame tells without the frames before it. */
struct FrameDescription {
  /** \brief Ok, or that of frameSize(): no other member is valid then. */
  CompressionStatus status;

  StreamFormat format = StreamFormat::Version1;
  std::uint32_t frame_number = 0; ///< number of the frame in its stream, from 1
  bool is_i_frame = false;        ///< decodes without any other frame
  bool is_of_changes = false;     ///< a P-frame that has only what changed
  Effort effort = Effort::Fast;   ///< Version1 only
  bool has_points = false;        ///< a scan: points in the order of their sensor
  /** \brief Occupied voxels; of the published layout only in I-frames. Of a scan, which
   * has none, as many as points. */
  std::size_t voxels = 0;
  /** \brief Points in the voxels: as many as voxels, unless these have numbers of
   * points. The decoded cloud has so many or, if the stream's is_organised is set, all
   * pixels of the scan, of which the others are missing ones. */
  std::size_t points = 0;

  VoxelGrid grid;                       ///< I-frames only
  IntensityScale intensity_scale;       ///< I-frames only; 0 bits: no intensities
  unsigned int colour_bits = 0;         ///< I-frames only; 0: no colours
  bool has_point_counts = false;        ///< I-frames only
  std::vector<FieldDescription> fields; ///< I-frames only
  /** \brief Columns and rows of a scan, of one without rays its points and 1; I-frames
   * only. */
  ImageSize scan;
  bool has_rays = false;     ///< depths along rays, else positions; likewise
  bool is_organised = false; ///< decoded clouds have its rows and columns; likewise
  /** \brief Decoded points come row by row, which need not be the order of the encoded
   * cloud; likewise. */
  bool is_row_by_row = false;

  std::optional<std::uint64_t> stamp; ///< I-frames: stamp, if the frame has one

  /** \brief P-frames: difference, modulo 2^64, to the stamp of the last frame that had
   * one, or to 0 if none had since the I-frame. */
  std::optional<std::int64_t> stamp_difference;

  /** \brief Name of the coordinate frame; a P-frame has it only if it has changed. */
  std::optional<std::string> frame_id;
};

/** \brief Reads the header of the frame at the beginning of a buffer. The frame need
 * not be complete, and its checksum is not verified.
 * \param[in] bytes the first byte
 * \param[in] count number of bytes at hand; most_frame_header_bytes are enough for any
 * header, and 8192 for all but those of lidars' scans
 * \param[in] limits of the decoder that gets the frame
 * \return Truncated if the bytes end within the header
 */
PCL_EXT_CODEC_EXPORT FrameDescription
describeFrame(const std::uint8_t* bytes,
              std::size_t count,
              const DecoderLimits& limits = DecoderLimits());

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::io
