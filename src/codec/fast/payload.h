// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "codec/fast/depth_residuals.h"
#include "codec/fast/frame_blocks.h"
#include "codec/fast/history.h"
#include "codec/fast/intensities.h"
#include "codec/fast/models.h"
#include "codec/fast/new_blocks.h"
#include "codec/fast/new_voxels.h"
#include "codec/fast/tracked_voxels.h"
#include "codec/history_use.h"
#include "codec/payload_coder.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

/** \brief Memory for a frame while it is coded, and the state after it until learn().
 * May be used by several streams in turn. */
struct Workspace {
  FrameBlocks frame;
  TrackedVoxels tracked_voxels;
  NewVoxels new_voxels;
  NewBlocks new_blocks;
  HistoryUpdate history_update;
  Intensities intensities;
  Intensities points; ///< numbers of points beside intensities
  std::vector<std::uint16_t> point_symbols;
  /** \brief Decoder: the models after the frame, exchanged with those of the stream by
   * learn(). Encoder: those of a trial. */
  std::unique_ptr<Models> models = std::make_unique<Models>();
  /** \brief The history after the frame; in a P-frame without statistics, which are
   * updated in the history of the stream. */
  History next_history;
  std::vector<std::uint32_t> ranges; ///< encoder only: symbols
  std::vector<std::uint16_t> words;  ///< encoder only: words of the rANS states
  std::vector<std::uint8_t> bytes;   ///< decoder only
};

/** \brief Payloads of the effort fast (doc/bitstream_fast.md). With a depth model, a
 * ClassedRow of the residuals follows the base symbols. */
class Payload : public PayloadCoder {
public:
  std::size_t
  match(CodingWorkspace& memory, const VoxelFrame& frame) override;

  PayloadSizes
  encode(CodingWorkspace& memory,
         const VoxelFrame& frame,
         bool is_i_frame,
         std::vector<std::uint8_t>& payload) override;

  bool
  decode(CodingWorkspace& memory,
         const CodedPayload& payload,
         VoxelFrame& frame,
         PayloadSizes& sizes) override;

  void
  learn() noexcept override;

  void
  discard() noexcept override;

  void
  releaseMemory() override;

  std::size_t
  trackedVoxels() const override
  {
    return history_.voxelCount();
  }

  std::size_t
  trackedBlocks() const override
  {
    return history_.keys.size();
  }

  std::size_t
  modelBytes() const override
  {
    return sizeof(Payload) + sizeof(Models);
  }

private:
  void
  encodeVoxels(const VoxelFrame& frame,
               bool is_i_frame,
               const std::vector<std::uint16_t>& symbols,
               std::vector<std::uint8_t>& payload);

  std::size_t
  appendVoxels(Models& models,
               HistoryPart part,
               const VoxelFrame& frame,
               const std::vector<std::uint16_t>& symbols,
               std::vector<std::uint8_t>& payload);

  void
  followVoxels(const VoxelFrame& frame,
               Models& models,
               const std::vector<std::uint16_t>& symbols);

  bool
  decodeVoxels(const std::uint8_t* begin, const std::uint8_t* end, VoxelFrame& frame);

  template <class Coder>
  bool
  codeOccupancy(Coder& coder, Models& models);

  template <class Coder, class FrameT, class Symbol>
  bool
  codeSymbols(Coder& coder, Models& models, FrameT& frame, Symbol* symbols);

  void
  beginFrame(CodingWorkspace& memory,
             const VoxelFrame& frame,
             std::size_t voxel_count,
             bool is_i_frame);

  /** \brief The history before the current frame. */
  const History&
  before() const;

  /** \brief The statistics of the current frame: not those of the history in a frame
   * without it, as it may be invalid. */
  StatisticsTable&
  statistics() noexcept;

  StatisticsTable&
  pointStatistics() noexcept;

  StatisticsTable&
  beginPointStatistics();

  void
  restoreStatistics() noexcept;

  void
  learnHistory(HistoryPart part) noexcept;

  const std::vector<std::uint16_t>&
  firstSymbols(const VoxelFrame& frame) const;

  /** \brief Returns to the initial state, as an I-frame without voxels does. */
  void
  forget() noexcept;

  /** \brief What learn() has to change for a decoded frame. */
  enum class Change { None, Everything, VoxelsOnly, Emptied };

  std::unique_ptr<Models> models_ = std::make_unique<Models>();
  History history_;
  DepthResiduals residuals_;
  Workspace* work_ = nullptr; // of the current frame
  Change change_ = Change::None;
  HistoryUse history_use_;                   // encoder only
  HistoryPart part_ = HistoryPart::Replaced; // decoder only, of the current frame
  bool is_i_frame_ = true;                   // the current frame
  bool has_points_ = false;                  // beside intensities
  unsigned int changed_rows_ = 0; // of symbols, whose statistics the frame changed
  std::vector<std::uint8_t> base_payload_; // scratch, so that its memory is reused
};

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io
