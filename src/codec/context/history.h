// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "codec/depth_split.h"
#include "voxels/voxel_block.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

/** \brief A block of the history. */
struct HistoryBlock {
  std::uint64_t key;     ///< Morton key of the block
  std::uint64_t tracked; ///< cells that have a record, never 0
  std::uint64_t last;    ///< tracked cells that are occupied in the last frame
  std::uint32_t
      first_record;      ///< of the lowest tracked cell; the others follow in order
  std::uint8_t activity; ///< running mean of new voxels a frame, 0..7
};

/** \brief What is remembered of a voxel's symbols. */
struct SymbolRecord {
  std::uint16_t mean;      ///< running mean of the symbol, fixed point
  std::uint16_t deviation; ///< running mean of the distance from it, fixed point
};

/** \brief The record of one voxel. */
struct VoxelRecord : SymbolRecord {
  std::uint16_t probability; ///< running mean of the occupancy, 2^16 is 1
  std::uint8_t recent;       ///< occupancy in the last frames, the last one lowest
  std::uint8_t age;          ///< frames since the first, up to 31
};

/** \brief What is remembered of a voxel for the depth model. */
struct DepthRecord {
  std::int16_t offset = 0;    ///< running mean, see DepthPrediction
  std::uint8_t roughness = 0; ///< running mean of the residual, in sixteenths
};

/** \brief Statistics of the frames since the last I-frame, the same in encoder and
 * decoder: occupancy and intensity of each voxel with a record
 * (doc/bitstream_context.md, "History"). Integers only, so that it is the same on every
 * machine. */
class History {
public:
  const std::vector<HistoryBlock>&
  blocks() const
  {
    return blocks_;
  }

  /** \brief The records, in the order of the blocks and of their tracked cells. */
  const VoxelRecord*
  records() const
  {
    return records_.data();
  }

  /** \brief What is remembered of point symbols beside intensities, in the order of the
   * records. */
  const SymbolRecord*
  pointRecords() const
  {
    return point_records_.data();
  }

  /** \brief What is remembered for the depth model of a record, by its index. */
  DepthRecord
  depthRecord(std::size_t record) const
  {
    return has_depths_ ? depth_records_[record] : DepthRecord();
  }

  /** \brief Predicts the depths of a frame's voxels from the records.
   * \param[in] frame its blocks
   * \param[out] predictions one for each voxel
   */
  void
  predictDepths(const BlockList& frame,
                std::vector<DepthPrediction>& predictions) const;

  /** \brief Number of records. */
  std::size_t
  recordCount() const
  {
    return record_count_;
  }

  /** \brief Fraction bits of means and deviations: 4 for symbols of up
   * to 12 bits, fewer for larger ones. */
  static constexpr unsigned int
  fractionBitsOf(unsigned int symbol_bits)
  {
    return symbol_bits < 12 ? 4 : 16 - symbol_bits;
  }

  /** \brief Those of the records. */
  unsigned int
  fractionBits() const
  {
    return fraction_bits_;
  }

  /** \brief Removes all records, as at an I-frame.
   * \param[in] symbol_bits bits of an intensity symbol from here on, 1..16
   */
  void
  clear(unsigned int symbol_bits);

  /** \brief Allocates the memory that update() needs for a frame, so that it cannot
   * fail.
   * \param[in] frame its blocks
   * \param[in] has_depths it has a depth model
   * \param[in] is_i_frame all records will be removed first
   * \param[in] has_points it has point symbols beside intensities
   */
  void
  makeRoom(const BlockList& frame,
           bool has_depths,
           bool is_i_frame,
           bool has_points = false);

  /** \brief Updates the records with a frame.
   * \param[in] frame its blocks
   * \param[in] base_symbols of its voxels
   * \param[in] depths one element for each voxel; null without a depth model
   * \param[in] is_i_frame its voxels start with a higher probability than new voxels of
   * a P-frame
   * \param[in] points point symbols beside intensities, one for each voxel; null
   * without
   */
  void
  update(const BlockList& frame,
         const std::vector<std::uint16_t>& base_symbols,
         const DepthObservations* depths,
         bool is_i_frame,
         const std::vector<std::uint16_t>* points = nullptr);

  /** \brief Releases memory that the tracked voxels do not need. */
  void
  releaseMemory();

private:
  struct Learning;

  std::vector<HistoryBlock> blocks_;
  // The first `record_count_` elements are in use. Not resized to them, as growing
  // again would initialise the elements.
  std::vector<VoxelRecord> records_;
  std::size_t record_count_ = 0;
  // Beside the records, once a frame had a depth model.
  std::vector<DepthRecord> depth_records_;
  bool has_depths_ = false;
  std::vector<SymbolRecord> point_records_; // likewise
  bool has_points_ = false;
  unsigned int fraction_bits_ = 4;
  // The next state; members so that their memory is reused.
  std::vector<HistoryBlock> next_blocks_;
  std::vector<VoxelRecord> next_records_;
  std::vector<DepthRecord> next_depth_records_;
  std::vector<SymbolRecord> next_point_records_;
};

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io
