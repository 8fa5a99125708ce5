#include "codec/context/payload.h"

#include "codec/context/entropy_coder.h"

#include <algorithm>
#include <utility>

namespace pcl_ext {
namespace io {
namespace context {

Payload::Payload(bool is_small)
: is_small_(is_small)
, fresh_models_(freshModels(is_small))
, models_(fresh_models_)
, trial_models_(fresh_models_)
{}

const Payload::Models&
Payload::freshModels(bool is_small)
{
  if (is_small) {
    static const Models models(true);
    return models;
  }
  static const Models models(false);
  return models;
}

FrameContext
Payload::contextOf(const VoxelFrame& frame, bool uses_history)
{
  empty_history_.clear(frame.intensity_scale.bits);
  return {uses_history ? history_ : empty_history_,
          frame.grid.depth,
          frame.intensity_scale.bits,
          frame.depth_model ? &*frame.depth_model : nullptr};
}

/** \brief Begins with the depth model of a frame whose blocks are coded. */
void
Payload::splitByDepth(const FrameContext& context)
{
  context.history.predictDepths(blocks_, intensities_.predictions);
  intensities_.split.begin(
      *context.depth_model, blocks_, intensities_.predictions, context.maxSymbol());
}

std::size_t
Payload::match(CodingWorkspace& /*memory*/, const VoxelFrame& frame)
{
  blocks_.assign(frame.keys);
  is_matched_ = true;
  return frame_.match(history_, blocks_);
}

PayloadSizes
Payload::encode(CodingWorkspace& /*memory*/,
                const VoxelFrame& frame,
                bool is_i_frame,
                std::vector<std::uint8_t>& payload)
{
  const std::size_t begin = payload.size();
  const std::size_t voxels = frame.size();
  const bool tries_history = !is_i_frame && (voxels == 0 || history_use_.isUseful());
  bool uses_history = tries_history;
  if (tries_history)
    trial_models_ = models_;
  PayloadSizes sizes = encodeAs(frame, is_i_frame, tries_history, payload);
  const std::size_t bytes = payload.size() - begin;
  const auto encode_again = [&](bool with_history) {
    payload.resize(begin);
    models_ = trial_models_;
    sizes = encodeAs(frame, false, with_history, payload);
    return payload.size() - begin;
  };
  if (!uses_history)
    // Models that start anew cost some bytes, which frames without the history do not.
    history_use_.measure(voxels, is_i_frame ? bytes - bytes / 32 : bytes);
  else if (history_use_.isDoubtful(voxels, bytes)) {
    const std::size_t bytes_without = encode_again(false);
    history_use_.measure(voxels, bytes_without);
    uses_history = history_use_.isWorth(bytes, bytes_without);
    if (uses_history)
      encode_again(true);
  }
  if (!uses_history)
    history_use_.addWithout(tries_history);
  else if (voxels > 0)
    history_use_.addWith();
  prepareLearning(frame, uses_history);
  learnHistory();
  return sizes;
}

/** \brief Encodes a frame with or without the history, and adapts the models. */
PayloadSizes
Payload::encodeAs(const VoxelFrame& frame,
                  bool is_i_frame,
                  bool uses_history,
                  std::vector<std::uint8_t>& payload)
{
  const std::size_t begin = payload.size();
  const FrameContext context = contextOf(frame, uses_history);
  if (is_i_frame)
    models_ = fresh_models_;
  if (!uses_history || !is_matched_) {
    blocks_.assign(frame.keys);
    frame_.match(context.history, blocks_);
  }
  is_matched_ = false;
  if (frame.hasIntensities())
    copyNumbers(frame.intensities, intensities_.symbols);
  else
    intensities_.symbols.assign(frame.size(), 0);
  if (context.depth_model != nullptr) {
    splitByDepth(context);
    intensities_.split.numbersOf(intensities_.symbols, intensities_.numbers);
  }
  else
    copyNumbers(intensities_.symbols, intensities_.numbers);
  PayloadSizes sizes;
  if (!frame.keys.empty())
    sizes.occupancy = is_small_ ? encodeWith<true>(context, is_i_frame, payload)
                                : encodeWith<false>(context, is_i_frame, payload);
  sizes.intensity = payload.size() - begin - sizes.occupancy;
  return sizes;
}

template <bool IsSmall>
std::size_t
Payload::encodeWith(const FrameContext& context,
                    bool is_i_frame,
                    std::vector<std::uint8_t>& payload)
{
  const std::size_t begin = payload.size();
  DecisionCoding<BinaryRangeEncoder, IsSmall> coding{BinaryRangeEncoder(payload)};
  if (!is_i_frame)
    coding.codeBypass(&context.history == &history_);
  codeOccupancy(coding, models_, context, intensities_.numbers.size());
  const std::size_t occupancy_bytes = coding.coder().settledBytes();
  if (context.symbol_bits > 0)
    IntensityPass(coding, models_.intensity, frame_.directory, context)
        .run(blocks_, intensities_.numbers);
  codeResiduals(coding, models_.intensity, context);
  coding.coder().finish();
  return std::min(occupancy_bytes, payload.size() - begin);
}

bool
Payload::decode(CodingWorkspace& /*memory*/,
                const std::uint8_t* begin,
                const std::uint8_t* end,
                std::size_t voxel_count,
                bool is_i_frame,
                VoxelFrame& frame,
                PayloadSizes& sizes)
{
  sizes = PayloadSizes();
  blocks_.clear();
  uses_history_ = !is_i_frame;
  if (voxel_count == 0) {
    if (begin != end)
      return false;
    intensities_.numbers.clear();
    intensities_.symbols.clear();
    if (is_i_frame)
      trial_models_ = fresh_models_;
  }
  else {
    if (!(is_small_ ? decodeWith<true>(
                          frame, is_i_frame, begin, end, voxel_count, sizes.occupancy)
                    : decodeWith<false>(
                          frame, is_i_frame, begin, end, voxel_count, sizes.occupancy)))
      return false;
  }
  sizes.intensity = static_cast<std::size_t>(end - begin) - sizes.occupancy;
  blocks_.voxelKeys(frame.keys);
  if (frame.hasIntensities())
    copyNumbers(intensities_.symbols, frame.intensities);
  prepareLearning(frame, uses_history_);
  has_models_ = voxel_count != 0 || is_i_frame;
  return true;
}

template <bool IsSmall>
bool
Payload::decodeWith(const VoxelFrame& frame,
                    bool is_i_frame,
                    const std::uint8_t* begin,
                    const std::uint8_t* end,
                    std::size_t voxel_count,
                    std::size_t& occupancy_bytes)
{
  trial_models_ = is_i_frame ? fresh_models_ : models_;
  DecisionCoding<BinaryRangeDecoder, IsSmall> coding{BinaryRangeDecoder(begin, end)};
  uses_history_ = !is_i_frame && coding.codeBypass(false);
  const FrameContext context = contextOf(frame, uses_history_);
  frame_.begin(context.history);
  if (!codeOccupancy(coding, trial_models_, context, voxel_count))
    return false;
  frame_.collect(context.history, blocks_);
  if (blocks_.voxelCount() != voxel_count)
    return false;
  occupancy_bytes =
      std::min(coding.coder().settledBytes(), static_cast<std::size_t>(end - begin));
  intensities_.numbers.resize(voxel_count);
  if (context.symbol_bits == 0)
    std::fill(intensities_.numbers.begin(), intensities_.numbers.end(), 0);
  else
    IntensityPass(coding, trial_models_.intensity, frame_.directory, context)
        .run(blocks_, intensities_.numbers);
  copyNumbers(intensities_.numbers, intensities_.symbols);
  if (context.depth_model != nullptr)
    splitByDepth(context);
  return codeResiduals(coding, trial_models_.intensity, context) &&
         coding.coder().isAtEnd();
}

/** \brief Codes which voxels are occupied. \return false if more than max_voxels */
template <typename CodingT>
bool
Payload::codeOccupancy(CodingT& coding,
                       Models& models,
                       const FrameContext& context,
                       std::size_t max_voxels)
{
  KnownVoxelPass known_voxels(coding, models.known_voxels, frame_, context);
  const std::size_t voxels = known_voxels.run();
  if (voxels > max_voxels)
    return false;
  NewVoxelPass new_voxels(
      coding, models.new_voxels, frame_, context, max_voxels - voxels);
  if (!new_voxels.run())
    return false;
  NewBlockPass new_blocks(coding,
                          models.children,
                          frame_,
                          context,
                          max_voxels - voxels - new_voxels.voxelCount());
  return new_blocks.run();
}

/** \brief Codes the residuals of a depth model, if there is one, after the numbers. */
template <typename CodingT>
bool
Payload::codeResiduals(CodingT& coding,
                       IntensityModels& models,
                       const FrameContext& context)
{
  if (context.depth_model == nullptr)
    return true;
  intensities_.split.predict(intensities_.numbers);
  return IntensityPass(coding, models, frame_.directory, context)
      .codeResiduals(intensities_.split, intensities_.symbols);
}

/** \brief Stores what learnHistory() needs of a frame. */
void
Payload::prepareLearning(const VoxelFrame& frame, bool uses_history)
{
  symbol_bits_ = frame.intensity_scale.bits;
  uses_history_ = uses_history;
  has_depths_ = frame.depth_model && !frame.keys.empty();
  if (has_depths_)
    intensities_.split.observe(intensities_.numbers, intensities_.symbols, depths_);
  history_.makeRoom(blocks_, has_depths_, !uses_history);
}

void
Payload::learn() noexcept
{
  if (has_models_)
    std::swap(models_, trial_models_);
  learnHistory();
}

void
Payload::learnHistory() noexcept
{
  if (!uses_history_)
    history_.clear(symbol_bits_);
  history_.update(
      blocks_, intensities_.numbers, has_depths_ ? &depths_ : nullptr, !uses_history_);
}

void
Payload::releaseMemory()
{
  history_.releaseMemory();
  blocks_ = BlockList();
  frame_ = Frame();
  intensities_ = CodedIntensities();
  depths_ = DepthObservations();
}

} // namespace context
} // namespace io
} // namespace pcl_ext
