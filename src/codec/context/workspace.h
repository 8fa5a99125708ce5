#pragma once

#include "voxels/block_directory.h"
#include "codec/context/history.h"
#include "codec/context/models.h"
#include "voxels/voxel_block.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief Blocks of a frame while they are coded; kept from frame to frame so that
 * their memory is reused. */
struct Workspace {
  /** \brief Occupied cells: of the blocks of the history, then of the new blocks. */
  std::vector<std::uint64_t> occupied;
  std::vector<std::uint64_t> new_keys; ///< of the new blocks, ascending
  BlockDirectory directory;            ///< into `occupied`

  // The encoder's: new voxels in each block of the history, and the new blocks,
  // ascending. A decoder's are 0, and none.
  std::vector<std::uint64_t> new_cells;
  std::vector<std::uint64_t> target_keys;
  std::vector<std::uint64_t> target_masks;

  /** \brief Begins with a frame.
   * \param[in] history what is known before the frame
   * \param[in] frame its blocks, of which `occupied` gets the known cells; the decoder
   * gives null
   */
  void
  begin(const History& history, const BlockList* frame);

  /** \brief The blocks that were coded, ascending. */
  void
  collect(const History& history, BlockList& frame) const;
};

} // namespace context
} // namespace io
} // namespace pcl_ext
