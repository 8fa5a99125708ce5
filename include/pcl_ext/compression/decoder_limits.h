// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/status.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \addtogroup io
 * @{ */

/** \brief Memory that the decoders of a program share: what they keep from frame to
 * frame. Where that is more, what was used the longest ago is dropped. A decoder whose
 * history was dropped answers P-frames with MissingReference and its reason, and
 * continues with an I-frame. Decoders get it by DecoderLimits::budget. Thread-safe.
 *
 * Beside it are the memory of the frames that are being decoded, and what the program
 * keeps of them.
 * \code
 * pcl_ext::io::DecoderLimits limits;
 * limits.budget = std::make_shared<pcl_ext::io::MemoryBudget>(std::size_t{1} << 30);
 * pcl_ext::io::FrameDecoder first(limits), second(limits);
 * \endcode
 */
class PCL_EXT_CODEC_EXPORT MemoryBudget {
public:
  /** \param[in] bytes that may be kept; 0: a quarter of machineBytes(), as frames in work
   * may take as much once more, and merging them likewise */
  explicit MemoryBudget(std::size_t bytes = 0);
  ~MemoryBudget();
  MemoryBudget(const MemoryBudget&) = delete;
  MemoryBudget&
  operator=(const MemoryBudget&) = delete;

  /** \brief Bytes that may be kept. */
  std::size_t
  limit() const;

  /** \brief Bytes that are kept, an estimate that is rather too high. */
  std::size_t
  used() const;

  /** \brief How often something was dropped. */
  std::size_t
  drops() const;

  /** \brief Memory of the machine, bytes, or of the control group of a Linux container if
   * that is less; 4 GiB where it is not known. */
  static std::size_t
  machineBytes();

private:
  friend class MemoryShare;
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/** \brief Limits of time and memory of decoding, for untrusted bytes. */
struct DecoderLimits {
  /** \brief The most voxels that a frame may have, whatever max_voxels is; as an encoder
   * writes them, in at most 2^26 blocks of 4 x 4 x 4. */
  static constexpr std::size_t most_voxels = std::size_t{1} << 28;

  /** \brief Bytes of one frame, and bytes skipped while looking for one. */
  std::size_t max_frame_bytes = std::size_t{1} << 28;

  /** \brief Voxels of one frame, or points of a scan, up to most_voxels. A frame takes
   * up to 120 bytes of memory for each of its voxels and 480 for each of its blocks of
   * 4 x 4 x 4; the memory is released a few frames later. A scan takes up to 130 for
   * each point and 20 for each pixel, and voxels made of it as much as others.
   * retain_octree, which builds PCL's octree of pointers, at least doubles this. */
  std::size_t max_voxels = std::size_t{1} << 26;

  /** \brief Points of one frame, where the stream has the number of points of each
   * voxel, or pixels of a scan; a decoded cloud has as many. Values above 16 max_voxels
   * count as that. */
  std::size_t max_points = std::size_t{1} << 30;

  /** \brief Values of the fields of one frame, of eight bytes each. */
  std::size_t max_field_values = std::size_t{1} << 30;

  /** \brief Voxels, or points of a scan, that a frame may have however few bytes it has:
   * with more, it has a
   * byte for 64 of them. With more than 2^24 points, 2^26 values of fields, or blocks
   * than the lesser of this and 2^20, it has a byte for 256, 512 or 8 of these. The bytes
   * of a P-frame are all since the last I-frame. 2^26 and above: no such limits. The
   * published layout has only that of voxels, without regard to its bytes. */
  std::size_t free_voxels = std::size_t{1} << 23;

  /** \brief Memory that the decoder shares with others; none: it keeps what it needs. A
   * frame that takes more than the whole of it is refused. */
  std::shared_ptr<MemoryBudget> budget;

  /** \brief Those where a budget bounds the memory of all frames: the default ones, but
   * as many voxels as a frame may have. */
  static DecoderLimits
  ofBudget(std::shared_ptr<MemoryBudget> shared_budget)
  {
    DecoderLimits limits;
    limits.max_voxels = most_voxels;
    limits.budget = std::move(shared_budget);
    return limits;
  }

  /** \brief Those of frames that are looked at, but not decoded. */
  static DecoderLimits
  none()
  {
    constexpr std::size_t any = (std::numeric_limits<std::uint32_t>::max)();
    return {any, any, any, any, any, nullptr};
  }
};

/** \brief Checks limits, which are above 0.
 * \return Ok, or InvalidSettings with the field
 */
PCL_EXT_CODEC_EXPORT CompressionStatus
checkLimits(const DecoderLimits& limits);

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::io
