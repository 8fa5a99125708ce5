#pragma once

#include "context_coder.h"
#include "payload_coder.h"
#include "payload_context.h"
#include "voxel_block.h"
#include "voxel_history.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Payloads of the efforts balanced and small: ContextCoder, and the history that
 * it looks at. */
class ContextPayload : public PayloadCoder {
public:
  /** \brief At the start of a stream.
   * \param[in] is_mixing see ContextCoder
   */
  explicit ContextPayload(bool is_mixing);

  PayloadSizes
  encode(const VoxelFrame& frame,
         bool is_i_frame,
         std::vector<std::uint8_t>& payload) override;

  bool
  decode(const std::uint8_t* begin,
         const std::uint8_t* end,
         std::size_t voxel_count,
         bool is_i_frame,
         VoxelFrame& frame,
         PayloadSizes& sizes) override;

  std::size_t
  knownVoxels(const VoxelFrame& frame) override;

  std::size_t
  recordCount() const override
  {
    return history_.recordCount();
  }

private:
  PayloadContext
  contextOf(const VoxelFrame& frame, bool is_i_frame);

  void
  learn(const VoxelFrame& frame, bool is_i_frame);

  ContextCoder coder_;
  std::uint16_t forgotten_below_;
  VoxelHistory history_;
  VoxelHistory empty_history_; // of I-frames, as a failure must not clear the other
  // Of the current frame; members so that their memory is reused.
  BlockList blocks_;
  CodedIntensities intensities_;
  DepthObservations depths_;
};

} // namespace io
} // namespace pcl_ext
