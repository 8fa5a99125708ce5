#pragma once

#include "codec/context/history.h"
#include "codec/depth_split.h"
#include "codec/fast/classed_row.h"
#include "codec/fast/coder.h"
#include "codec/payload_coder.h"
#include "voxels/voxel_block.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief Payloads of the effort fast: FrameCoder, behind which a row of its own has the
 * depth model's rests. FrameCoder's history is arranged for it (fast_history.h), as to
 * learn the other coder's takes longer than all that it does. */
class Payload : public PayloadCoder {
public:
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
  discard() noexcept override;

  void
  giveBackMemory() override;

  std::size_t
  knownVoxels(CodingWorkspace& work, const VoxelFrame& frame) override
  {
    return coder_.knownVoxels(work.fast(), frame.keys);
  }

  std::size_t
  recordCount() const override
  {
    return coder_.recordCount();
  }

private:
  void
  encodeWithDepth(Workspace& work,
                  const VoxelFrame& frame,
                  bool is_i_frame,
                  std::vector<std::uint8_t>& payload);

  bool
  decodeRests(const std::uint8_t* begin,
              const std::uint8_t* end,
              bool is_i_frame,
              VoxelFrame& frame);

  void
  beginSplit(const VoxelFrame& frame);

  void
  collectClasses();

  /** \brief Forgets all frames, as an I-frame without voxels does. */
  void
  forget() noexcept;

  /** \brief What is needed for the current frame; a member so that its memory is reused. */
  struct DepthWork {
    BlockList blocks;
    DepthSplit split;
    std::vector<std::uint16_t> numbers;
    std::vector<std::uint8_t> numbers_payload;
    std::vector<std::uint16_t> row;
    std::vector<std::uint8_t> row_classes;
  };

  /** \brief What a decoded frame is to change. */
  enum class Change { None, Everything, VoxelsOnly, Emptied };

  FrameCoder coder_;
  ClassedRow rests_;
  std::size_t rests_begin_ = 0; // in the payload
  Change change_ = Change::None;
  context::History no_history_; // without one a depth model predicts from the centres
  DepthWork own_;
};

} // namespace fast
} // namespace io
} // namespace pcl_ext
