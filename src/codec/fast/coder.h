#pragma once

#include "codec/fast/history.h"
#include "codec/fast/models.h"
#include "codec/fast/workspace.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief Codes the payload of one stream's frames, an encoder or a decoder of its own
 * for each stream and direction (doc/bitstream_fast.md).
 *
 * It remembers the frames since the last I-frame. Everything adapts; nothing depends on
 * the compiler or the width of its words. Memory is kept from frame to frame.
 */
class FrameCoder {
public:
  /** \brief Appends the payload of a frame, and learns the frame.
   * \param[in,out] work memory for it
   * \param[in] is_i_frame the frame stands alone; the first one has to
   * \param[in] keys Morton keys of the voxels, ascending, 1..2^24 of them
   * \param[in] symbols as many intensity symbols, below 2^bits
   * \param[in] bits of a symbol, 1..16; that of the last frame unless this is an I-frame
   * \param[in] depth of the grid, 1..21; that of the last frame unless this is an I-frame
   * \param[in,out] payload where to append
   */
  void
  encode(Workspace& work,
         bool is_i_frame,
         const std::vector<std::uint64_t>& keys,
         const std::vector<std::uint16_t>& symbols,
         unsigned int bits,
         unsigned int depth,
         std::vector<std::uint8_t>& payload);

  /** \brief Forgets all frames, as at an I-frame. */
  void
  reset() noexcept;

  /** \brief Reads a payload; either learn() or discard() follows if that succeeds. An
   * exception leaves the coder fit for nothing but its end.
   * \param[in,out] work memory for it, not to be used for other frames before
   * \param[in] begin first byte
   * \param[in] end behind the last byte
   * \param[in] is_i_frame as for `encode`
   * \param[in] voxel_count number of voxels, 1..2^24; the caller has checked it against
   * its limits
   * \param[in] bits as for `encode`
   * \param[in] depth as for `encode`
   * \param[out] keys Morton keys of the voxels, ascending
   * \param[out] symbols their symbols
   * \return false if the bytes are not what an encoder writes; the coder is then as it
   * was before, keys and symbols are anything
   */
  bool
  decode(Workspace& work,
         const std::uint8_t* begin,
         const std::uint8_t* end,
         bool is_i_frame,
         std::size_t voxel_count,
         unsigned int bits,
         unsigned int depth,
         std::vector<std::uint64_t>& keys,
         std::vector<std::uint16_t>& symbols);

  /** \brief Learns the frame that was decoded last. */
  void
  learn() noexcept;

  /** \brief Leaves the coder as it was before the frame that was decoded last. */
  void
  discard() noexcept;

  /** \brief Gives back the memory that what is known does not need. */
  void
  giveBackMemory()
  {
    history_.giveBackMemory();
  }

  /** \brief Number of voxels that are known of the last frames; seven times those of the
   * largest frame at most. */
  std::size_t
  recordCount() const;

  /** \brief How much of a frame is known.
   * \param[in,out] work memory for it
   * \param[in] keys Morton keys of its voxels, ascending
   * \return number of them that are known
   */
  std::size_t
  knownVoxels(Workspace& work, const std::vector<std::uint64_t>& keys) const;

private:
  void
  beginFrame(Workspace& work,
             bool is_i_frame,
             unsigned int depth,
             std::size_t voxel_count);

  const History&
  before() const;

  /** \brief The moments of this frame: those of the history are kept until another
   * I-frame is known to be whole. */
  Moments&
  moments() noexcept;

  void
  learnHistory() noexcept;

  std::unique_ptr<Models> models_ = std::make_unique<Models>();
  History history_;
  Workspace* workspace_ = nullptr; // of the last frame
};

} // namespace fast
} // namespace io
} // namespace pcl_ext
