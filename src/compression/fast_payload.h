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
  knownVoxels(const VoxelFrame& frame) override
  {
    return coder_.knownVoxels(frame.keys);
  }

  std::size_t
  recordCount() const override
  {
    return coder_.recordCount();
  }

private:
  void
  encodeWithDepth(const VoxelFrame& frame,
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
  forget();

  FastCoder coder_;
  ClassedRow rests_;
  std::size_t rests_begin_ = 0; // in the payload
  // Of the current frame; members so that their memory is reused.
  BlockList blocks_;
  DepthSplit split_;
  VoxelHistory no_history_; // without one a depth model predicts from the centres
  std::vector<std::uint16_t> numbers_;
  std::vector<std::uint8_t> numbers_payload_;
  std::vector<std::uint16_t> row_;
  std::vector<std::uint8_t> row_classes_;
};

} // namespace io
} // namespace pcl_ext
