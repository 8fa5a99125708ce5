// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "codec/context/frame_blocks.h"
#include "codec/context/history.h"
#include "codec/context/intensities.h"
#include "codec/context/new_blocks.h"
#include "codec/context/new_voxels.h"
#include "codec/context/tracked_voxels.h"
#include "codec/history_use.h"
#include "codec/payload_coder.h"
#include "voxels/voxel_block.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

/** \brief Payloads of the efforts balanced and small (doc/bitstream_context.md): a
 * frame is a sequence of binary decisions, each coded with an adaptive probability of
 * its context. */
class Payload : public PayloadCoder {
public:
  /** \brief A coder at the start of a stream.
   * \param[in] is_small effort small: mix the probabilities of several contexts of each
   * decision; else, for balanced, use one context
   */
  explicit Payload(bool is_small);

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
  discard() noexcept override
  {}

  void
  releaseMemory() override;

  std::size_t
  trackedVoxels() const override
  {
    return history_.recordCount();
  }

  std::size_t
  trackedBlocks() const override
  {
    return history_.blocks().size();
  }

  std::size_t
  modelBytes() const override
  {
    return sizeof(Payload) + models_.memoryBytes() + trial_models_.memoryBytes();
  }

private:
  struct Models {
    /** \param[in] has_points beside intensities */
    Models(bool is_small, bool has_points)
    : tracked_voxels(is_small)
    , new_voxels(is_small)
    , children(is_small)
    , intensity(is_small)
    {
      if (has_points)
        points.emplace(is_small);
    }

    /** \brief Bytes of memory besides the object. */
    std::size_t
    memoryBytes() const
    {
      return tracked_voxels.voxel.memoryBytes() + new_voxels.block.memoryBytes() +
             children.child.memoryBytes() + intensity.memoryBytes() +
             (points ? points->memoryBytes() : 0);
    }

    TrackedVoxelModels tracked_voxels;
    NewVoxelModels new_voxels;
    ChildModels children;
    IntensityContexts intensity;
    std::optional<IntensityContexts> points; ///< beside intensities
  };

  /** \brief Models in their initial state, as at an I-frame, shared by all streams. */
  static const Models&
  freshModels(bool is_small, bool has_points);

  FrameParameters
  parametersOf(const VoxelFrame& frame, bool uses_history);

  template <typename EncodeT>
  HistoryPart
  encodePFrame(std::size_t voxels, const EncodeT& encode_as);

  PayloadSizes
  encodeAs(const VoxelFrame& frame,
           bool is_i_frame,
           HistoryPart part,
           std::vector<std::uint8_t>& payload);

  void
  splitByDepth(const FrameParameters& parameters);

  template <bool IsSmall>
  PayloadSizes
  encodeWith(const VoxelFrame& frame,
             const FrameParameters& parameters,
             bool is_i_frame,
             HistoryPart part,
             std::vector<std::uint8_t>& payload);

  template <bool IsSmall>
  bool
  decodeWith(const CodedPayload& payload, VoxelFrame& frame, PayloadSizes& sizes);

  template <typename CodingT>
  bool
  codeOccupancy(CodingT& coding,
                Models& models,
                const FrameParameters& parameters,
                std::size_t max_voxels,
                std::size_t max_blocks = most_blocks);

  template <typename CodingT>
  bool
  codeResiduals(CodingT& coding,
                IntensityContexts& models,
                const FrameParameters& parameters);

  template <typename CodingT, class FrameT>
  bool
  codePoints(CodingT& coding,
             Models& models,
             const FrameParameters& parameters,
             FrameT& frame);

  void
  prepareLearning(const VoxelFrame& frame, HistoryPart part);

  void
  learnHistory() noexcept;

  bool is_small_;
  Models models_;
  /** \brief Decoder: after the frame, until learn(). Encoder: before a frame that tries
   * the history. */
  Models trial_models_;
  History history_;
  History empty_history_; // for frames without, as a failure must not clear history_
  // Encoder only.
  HistoryUse history_use_;
  bool is_matched_ = false; // with the history, by match()
  // Of the current frame; members so that their memory is reused.
  BlockList blocks_;
  FrameBlocks frame_;
  CodedIntensities intensities_;
  DepthObservations depths_;
  // For learnHistory().
  unsigned int symbol_bits_ = 8;
  bool has_points_ = false; // beside intensities
  HistoryPart history_part_ = HistoryPart::Replaced;
  bool has_depths_ = false;
  bool has_too_many_blocks_ = false; // of a frame that cannot be decoded
  bool has_models_ = false; // a decoder's trial_models_ are those after the frame
};

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io
