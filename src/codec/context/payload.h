#pragma once

#include "codec/context/coder.h"
#include "codec/context/frame_context.h"
#include "codec/context/history.h"
#include "codec/payload_coder.h"
#include "voxels/voxel_block.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief Payloads of the efforts balanced and small: FrameCoder, and the history that
 * it looks at. */
class Payload : public PayloadCoder {
public:
  /** \brief At the start of a stream.
   * \param[in] is_mixing see FrameCoder
   */
  explicit Payload(bool is_mixing);

  PayloadSizes
  encode(CodingWorkspace& work,
         const VoxelFrame& frame,
         bool is_i_frame,
         std::vector<std::uint8_t>& payload) override;

  bool
  decode(CodingWorkspace& work,
         const std::uint8_t* begin,
         const std::uint8_t* end,
         std::size_t voxel_count,
         bool is_i_frame,
         VoxelFrame& frame,
         PayloadSizes& sizes) override;

  void
  learn() noexcept override;

  void
  discard() noexcept override
  {}

  void
  giveBackMemory() override;

  std::size_t
  knownVoxels(CodingWorkspace& work, const VoxelFrame& frame) override;

  std::size_t
  recordCount() const override
  {
    return history_.recordCount();
  }

private:
  FrameContext
  contextOf(const VoxelFrame& frame, bool is_i_frame);

  /** \brief Keeps all that learnHistory() needs of a frame. */
  void
  prepareLearning(const VoxelFrame& frame, bool is_i_frame);

  void
  learnHistory() noexcept;

  FrameCoder coder_;
  std::uint16_t forgotten_below_;
  History history_;
  History empty_history_; // of I-frames, as a failure must not clear the other
  // Of the current frame; members so that their memory is reused.
  BlockList blocks_;
  CodedIntensities intensities_;
  DepthObservations depths_;
  // What it is to change.
  unsigned int symbol_bits_ = 8;
  bool is_i_frame_ = true;
  bool has_depths_ = false;
  bool has_models_ = false; // a decoder's, not yet learnt
};

} // namespace context
} // namespace io
} // namespace pcl_ext
