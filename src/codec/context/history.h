#pragma once

#include "codec/depth_split.h"
#include "voxels/voxel_block.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief A block of the history. */
struct HistoryBlock {
  std::uint64_t key;          ///< Morton key of the block
  std::uint64_t known;        ///< cells that have a record, never 0
  std::uint64_t last;         ///< of these, those that the last frame had
  std::uint32_t first_record; ///< of the lowest known cell; the others follow in order
  std::uint8_t activity;      ///< of new voxels in the last frames, 0..7
};

/** \brief The record of one voxel. */
struct VoxelRecord {
  std::uint16_t probability; ///< running share of frames that had it, 2^16 is 1
  std::uint16_t mean;        ///< running mean of the number, fixed point
  std::uint16_t deviation;   ///< mean distance from the mean, fixed point
  std::int16_t depth_offset; ///< running mean, see DepthPrediction
  std::uint8_t recent;       ///< a bit for each frame, the last one lowest
  std::uint8_t age;          ///< frames since the first, up to 31
  std::uint8_t roughness;    ///< running mean of the residual, in sixteenths
};

/** \brief What encoder and decoder remember of the frames since the last I-frame: for
 * each voxel with a record how often it was occupied, and with which intensity
 * (doc/bitstream_context.md, "History"). Integers only, so that it is the same on every
 * machine. */
class History {
public:
  const std::vector<HistoryBlock>&
  blocks() const
  {
    return blocks_;
  }

  /** \brief The records, in the order of the blocks and of their known cells. */
  const VoxelRecord*
  records() const
  {
    return records_.data();
  }

  /** \brief What the records tell of the depths of a frame's voxels.
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

  /** \brief Bits behind the binary point of means and deviations: 4 for symbols of up
   * to 12 bits, fewer for larger ones. */
  unsigned int
  fractionBits() const
  {
    return fraction_bits_;
  }

  /** \brief Removes all records, as at an I-frame.
   * \param[in] symbol_bits bits of an intensity symbol from here on, 1..16
   * \param[in] forgotten_below probability below which a record is forgotten from here
   * on, in 2^-16
   */
  void
  clear(unsigned int symbol_bits, std::uint16_t forgotten_below);

  /** \brief Takes the memory that update() will need for a frame, so that it cannot
   * fail.
   * \param[in] frame its blocks
   * \param[in] is_i_frame all records will be forgotten before
   */
  void
  makeRoom(const BlockList& frame, bool is_i_frame);

  /** \brief Learns a frame.
   * \param[in] frame its blocks
   * \param[in] numbers what was coded of its voxels' intensities: symbols, or numbers of
   * points
   * \param[in] depths one element for each voxel; null without a depth model
   * \param[in] is_i_frame its voxels start with a higher probability than those that a
   * P-frame brings
   */
  void
  update(const BlockList& frame,
         const std::vector<std::uint16_t>& numbers,
         const DepthObservations* depths,
         bool is_i_frame);

  /** \brief Gives back the memory that the known voxels do not need. */
  void
  giveBackMemory();

private:
  struct Learning;

  std::vector<HistoryBlock> blocks_;
  // Memory, of which the first `record_count_` elements are in use: a vector that shrinks
  // and grows again writes what it grows by.
  std::vector<VoxelRecord> records_;
  std::size_t record_count_ = 0;
  unsigned int fraction_bits_ = 4;
  std::uint16_t forgotten_below_ = 0;
  // The next state; members so that their memory is reused.
  std::vector<HistoryBlock> next_blocks_;
  std::vector<VoxelRecord> next_records_;
};

} // namespace context
} // namespace io
} // namespace pcl_ext
