#pragma once

#include "classed_row.h"
#include "depth_split.h"
#include "fast_coder.h"
#include "payload_coder.h"
#include "voxel_block.h"
#include "voxel_history.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Payloads of the effort fast: FastCoder, behind which a row of its own has the
 * depth model's rests. FastCoder's history is arranged for it (fast_history.h), as to
 * learn the other coder's takes longer than all that it does. */
class FastPayload : public PayloadCoder {
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
  encodeWithDepth(FastWorkspace& work,
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
  struct Workspace {
    BlockList blocks;
    DepthSplit split;
    std::vector<std::uint16_t> numbers;
    std::vector<std::uint8_t> numbers_payload;
    std::vector<std::uint16_t> row;
    std::vector<std::uint8_t> row_classes;
  };

  /** \brief What a decoded frame is to change. */
  enum class Change { None, Everything, VoxelsOnly, Emptied };

  FastCoder coder_;
  ClassedRow rests_;
  std::size_t rests_begin_ = 0; // in the payload
  Change change_ = Change::None;
  VoxelHistory no_history_; // without one a depth model predicts from the centres
  Workspace own_;
};

} // namespace io
} // namespace pcl_ext
