#pragma once

#include "codec/fast/frame.h"
#include "codec/fast/models.h"

#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief Codes the blocks that are not in the history (doc/bitstream_fast.md, "New blocks"):
 * the octree above them level by level, then their cells.
 *
 * A Coder is NibbleEncoder or NibbleDecoder.
 */
class NewBlocks {
public:
  /** \brief Codes a frame whose voxels in known blocks are coded.
   * \param[in,out] frame a decoder sets the new blocks
   * \return false if the bytes are invalid, or decode to more voxels than the frame has;
   * never in an encoder
   */
  template <class Coder>
  bool
  code(Coder& coder, Models& models, Frame& frame);

private:
  void
  collectNodes(const Frame& frame);

  template <class Coder>
  bool
  codeNodes(Coder& coder, Models& models, unsigned int level, Frame& frame);

  template <class Coder>
  static bool
  codeBlockCells(Coder& coder, Models& models, Frame& frame);

  // Keys of the nodes of a level and, in a decoder, of their children.
  std::vector<std::uint64_t> node_keys_;
  std::vector<std::uint64_t> child_keys_;
  std::vector<std::vector<std::uint8_t>> node_masks_; // encoder only: by level
};

} // namespace fast
} // namespace io
} // namespace pcl_ext
