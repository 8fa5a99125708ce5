#pragma once

#include "codec/context/frame.h"
#include "codec/context/history.h"
#include "codec/context/intensities.h"
#include "codec/context/known_voxels.h"
#include "codec/context/new_voxels.h"
#include "codec/payload_coder.h"
#include "voxels/voxel_block.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief Payloads of the efforts balanced and small (doc/bitstream_context.md): a frame is a
 * sequence of binary decisions, each coded with an adaptive probability of its context. */
class Payload : public PayloadCoder {
public:
  /** \brief A coder at the start of a stream.
   * \param[in] is_mixing effort small: mix the probabilities of several contexts of each
   * decision; else, for balanced, use one context
   */
  explicit Payload(bool is_mixing);

  std::size_t
  match(CodingWorkspace& memory, const VoxelFrame& frame) override;

  PayloadSizes
  encode(CodingWorkspace& memory,
         const VoxelFrame& frame,
         bool is_i_frame,
         std::vector<std::uint8_t>& payload) override;

  bool
  decode(CodingWorkspace& memory,
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
  releaseMemory() override;

  std::size_t
  recordCount() const override
  {
    return history_.recordCount();
  }

private:
  struct Models {
    explicit Models(bool is_mixing)
    : known_voxels(is_mixing), new_voxels(is_mixing), intensity(is_mixing)
    {}

    KnownVoxelModels known_voxels;
    NewVoxelModels new_voxels;
    IntensityModels intensity;
  };

  FrameContext
  contextOf(const VoxelFrame& frame, bool is_i_frame);

  void
  splitByDepth(const FrameContext& context);

  template <template <typename> class CodingT>
  std::size_t
  encodeWith(const FrameContext& context, std::vector<std::uint8_t>& payload);

  template <template <typename> class CodingT>
  bool
  decodeWith(const FrameContext& context,
             const std::uint8_t* begin,
             const std::uint8_t* end,
             std::size_t voxel_count,
             std::size_t& occupancy_bytes);

  template <typename CodingT>
  bool
  codeOccupancy(CodingT& coding,
                Models& models,
                const FrameContext& context,
                std::size_t max_voxels);

  template <typename CodingT>
  void
  encodeNumbers(CodingT& coding,
                const FrameContext& context,
                std::vector<std::uint8_t>& payload);

  template <typename CodingT>
  bool
  codeResiduals(CodingT& coding, IntensityModels& models, const FrameContext& context);

  void
  prepareLearning(const VoxelFrame& frame, bool is_i_frame);

  void
  learnHistory() noexcept;

  bool is_mixing_;
  std::uint16_t forgotten_below_;
  Models fresh_models_; // initial state, as at an I-frame
  Models models_;
  // In a decoder the models after the frame until learn(); in an encoder a copy from before
  // a trial.
  Models trial_models_;
  History history_;
  History empty_history_; // for I-frames, as a failure must not clear history_
  // Of the current frame; members so that their memory is reused.
  BlockList blocks_;
  Frame frame_;
  CodedIntensities intensities_;
  DepthObservations depths_;
  std::vector<std::uint8_t> payload_before_; // a copy from before a trial
  // For learnHistory().
  unsigned int symbol_bits_ = 8;
  bool is_i_frame_ = true;
  bool has_depths_ = false;
  bool has_models_ = false; // a decoder's trial_models_ are those after the frame
};

} // namespace context
} // namespace io
} // namespace pcl_ext
