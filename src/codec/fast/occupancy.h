#pragma once

#include "codec/fast/frame.h"
#include "codec/fast/models.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief Codes which voxels are occupied (doc/bitstream_fast.md, "Occupancy"), in
 * three passes: those that the history knows, new ones in blocks that it knows, new
 * blocks. What the frame teaches goes into a history of its own.
 *
 * A Coder is NibbleEncoder or NibbleDecoder.
 */
class Occupancy {
public:
  /** \brief For an encoder: sorts the voxels into blocks and finds the known ones.
   * \param[in] keys Morton keys, ascending, at least one
   */
  static void
  match(const History& before, const std::vector<std::uint64_t>& keys, Frame& frame);

  /** \brief Codes a frame.
   * \param[in] before the history; empty at an I-frame
   * \param[out] after the history behind this frame, its moments excepted
   * \param[in,out] moments those of the history; new voxels get none
   * \param[in,out] frame as `match` left it, or, in a decoder, its voxel count; its
   * blocks come out
   * \return false if the bytes are not such a frame; never in an encoder
   */
  template <class Coder>
  bool
  code(Coder& coder,
       Models& models,
       const History& before,
       History& after,
       Moments& moments,
       Frame& frame);

private:
  template <class Coder>
  bool
  codeKnownVoxels(Coder& coder,
                  Models& models,
                  const History& before,
                  History& after,
                  Frame& frame);

  template <class Coder>
  bool
  splitBucket(Coder& coder,
              Models& models,
              unsigned int past,
              const History& before,
              History& after,
              Frame& frame);

  template <class Coder>
  bool
  codeNewOctants(Coder& coder,
                 Models& models,
                 const History& before,
                 const Moments& moments,
                 Frame& frame);

  void
  collectRenewedBlocks(const History& before);

  template <class Coder>
  bool
  codeOctantMasks(Coder& coder, Models& models, const History& before, Frame& frame);

  template <class Coder>
  bool
  codeNewCells(Coder& coder,
               Models& models,
               const History& before,
               const Moments& moments,
               Frame& frame);

  template <bool is_decoder>
  bool
  placeNewCells(Frame& frame, std::size_t& several_count);

  template <class Coder>
  bool
  codeSeveralCells(Coder& coder,
                   Models& models,
                   std::size_t count,
                   const History& before,
                   Frame& frame);

  template <class Coder>
  bool
  codeNewBlocks(Coder& coder, Models& models, Frame& frame);

  void
  collectNodes(const Frame& frame);

  template <class Coder>
  bool
  codeNodes(Coder& coder, Models& models, unsigned int level, Frame& frame);

  template <class Coder>
  bool
  codeBlockCells(Coder& coder, Models& models, Frame& frame);

  static void
  makeRoom(const History& before, History& after, Moments& moments, const Frame& frame);

  bool
  learnBlocks(const History& before, History& after, Moments& moments, Frame& frame);

  void
  numberNewBlocks(const History& before, const Frame& frame);

  bool
  mergeBlocks(const History& before, History& after, Frame& frame);

  /** \brief What is known of an octant's cells before its new ones are coded. */
  struct Surroundings {
    std::uint8_t near; ///< open cells beside an occupied one
    std::uint8_t open; ///< cells of the grid that are not known
  };

  std::size_t found_voxels_ = 0; // by a decoder
  // Of these vectors only so many elements are in use as a count says.
  std::vector<std::uint8_t> occupancies_;    // of a bucket, eight voxels in each
  std::vector<std::uint8_t> contexts_;       // of the row that is coded
  std::vector<std::uint8_t> octant_symbols_; // for each known block
  // Known blocks with new voxels, ascending: their index in the history.
  std::size_t renewed_count_ = 0;
  std::vector<std::uint32_t> renewed_blocks_;
  std::vector<std::uint32_t>
      several_; // blocks with several such octants, octants with several new voxels
  std::size_t octant_count_ = 0;
  std::vector<VoxelPlace> octants_; // first cells of octants with new voxels
  std::vector<Surroundings> surroundings_;
  std::vector<std::uint8_t> cell_symbols_;
  std::vector<std::uint32_t> new_numbers_;   // of the new blocks
  std::vector<std::uint32_t> freed_numbers_; // of blocks that have no voxels any more
  // Octree above the new blocks: keys of a level, and in an encoder masks of all.
  std::vector<std::uint64_t> node_keys_;
  std::vector<std::uint64_t> other_node_keys_;
  std::vector<std::vector<std::uint8_t>> node_masks_;
};

} // namespace fast
} // namespace io
} // namespace pcl_ext
