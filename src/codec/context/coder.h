#pragma once

#include "codec/context/frame_context.h"
#include "codec/context/intensities.h"
#include "codec/context/known_voxels.h"
#include "codec/context/new_voxels.h"
#include "codec/context/workspace.h"
#include "voxels/voxel_block.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief The coder of the efforts balanced and small: each decision that makes up a
 * frame is a bit, coded with the probability that it had in its context so far. */
class FrameCoder {
public:
  /** \brief A coder that has learnt nothing.
   * \param[in] is_mixing mix the probabilities of several contexts of each decision, for
   * small; else one context decides, for balanced
   */
  explicit FrameCoder(bool is_mixing);

  /** \brief Appends the payload of a frame that has voxels, and learns it.
   * \param[in] context what the decoder knows, too
   * \param[in] frame blocks of the voxels
   * \param[in,out] intensities of the voxels; numbers and symbols are given
   * \param[in,out] payload where to append
   * \return bytes of the payload that tell the occupancy, the last one in part
   */
  std::size_t
  encode(const FrameContext& context,
         const BlockList& frame,
         CodedIntensities& intensities,
         std::vector<std::uint8_t>& payload);

  /** \brief Reads back what encode wrote; learn() makes it known.
   * \param[in] context as for encode
   * \param[in] begin first byte
   * \param[in] end end of the payload, all of which must be used
   * \param[in] voxel_count number of voxels of the frame, above 0
   * \param[out] frame blocks of the voxels
   * \param[out] intensities of the voxels
   * \param[out] occupancy_bytes as encode returns
   * \return false if the bytes are no payload of that many voxels
   */
  bool
  decode(const FrameContext& context,
         const std::uint8_t* begin,
         const std::uint8_t* end,
         std::size_t voxel_count,
         BlockList& frame,
         CodedIntensities& intensities,
         std::size_t& occupancy_bytes);

  /** \brief For an I-frame without voxels, which has no payload: prepares to forget all that
   * was learnt; learn() does it. */
  void
  prepareToForget()
  {
    trial_models_ = fresh_models_;
  }

  /** \brief Learns the frame that was decoded last. */
  void
  learn() noexcept
  {
    std::swap(models_, trial_models_);
  }

  /** \brief Gives back the memory that what was learnt does not need. */
  void
  giveBackMemory()
  {
    payload_before_ = std::vector<std::uint8_t>();
    workspace_ = Workspace();
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

  template <typename CodingT>
  bool
  codeOccupancy(CodingT& coding,
                Models& models,
                const FrameContext& context,
                const BlockList* frame,
                std::size_t max_voxels);

  /** \brief Codes the numbers of a frame, as if they were noise where that is smaller. */
  template <typename CodingT>
  void
  encodeNumbers(CodingT& coding,
                const FrameContext& context,
                const BlockList& frame,
                std::vector<std::uint16_t>& numbers,
                std::vector<std::uint8_t>& payload);

  template <template <typename> class CodingT>
  std::size_t
  encodeWith(const FrameContext& context,
             const BlockList& frame,
             CodedIntensities& intensities,
             std::vector<std::uint8_t>& payload);

  template <template <typename> class CodingT>
  bool
  decodeWith(const FrameContext& context,
             const std::uint8_t* begin,
             const std::uint8_t* end,
             std::size_t voxel_count,
             BlockList& frame,
             CodedIntensities& intensities,
             std::size_t& occupancy_bytes);

  bool is_mixing_;
  Models fresh_models_; // as at an I-frame
  Models models_;
  Models
      trial_models_; // what decoding learns, until it is known to have succeeded; and
                     // what encoding had learnt before a trial
  std::vector<std::uint8_t> payload_before_; // a trial
  Workspace workspace_;
};

} // namespace context
} // namespace io
} // namespace pcl_ext
