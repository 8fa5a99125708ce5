#include "codec/context/payload.h"

#include "codec/context/entropy_coder.h"

#include <algorithm>
#include <utility>

namespace pcl_ext {
namespace io {
namespace context {

namespace {

// Probabilities, in units of 2^-16, below which a record is removed, as it saves too few
// bytes for its time.
constexpr std::uint16_t forgotten_below_balanced = 3000;
constexpr std::uint16_t forgotten_below_small = 1000;

} // namespace

Payload::Payload(bool is_mixing)
: is_mixing_(is_mixing)
, forgotten_below_(is_mixing ? forgotten_below_small : forgotten_below_balanced)
, fresh_models_(is_mixing)
, models_(fresh_models_)
, trial_models_(fresh_models_)
{}

FrameContext
Payload::contextOf(const VoxelFrame& frame, bool is_i_frame)
{
  empty_history_.clear(frame.intensity_scale.bits, forgotten_below_);
  return {is_i_frame ? empty_history_ : history_,
          is_i_frame,
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
  return frame_.match(history_, blocks_);
}

PayloadSizes
Payload::encode(CodingWorkspace& /*memory*/,
                const VoxelFrame& frame,
                bool is_i_frame,
                std::vector<std::uint8_t>& payload)
{
  const std::size_t begin = payload.size();
  const FrameContext context = contextOf(frame, is_i_frame);
  if (is_i_frame) {
    models_ = fresh_models_;
    blocks_.assign(frame.keys);
    frame_.match(context.history, blocks_);
  }
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
    sizes.occupancy = is_mixing_ ? encodeWith<MixedContextCoding>(context, payload)
                                 : encodeWith<SingleContextCoding>(context, payload);
  sizes.intensity = payload.size() - begin - sizes.occupancy;
  prepareLearning(frame, is_i_frame);
  learnHistory();
  return sizes;
}

template <template <typename> class CodingT>
std::size_t
Payload::encodeWith(const FrameContext& context, std::vector<std::uint8_t>& payload)
{
  const std::size_t begin = payload.size();
  CodingT<BinaryRangeEncoder> coding{BinaryRangeEncoder(payload)};
  codeOccupancy(coding, models_, context, intensities_.numbers.size());
  const std::size_t occupancy_bytes = coding.coder().settledBytes();
  if (context.symbol_bits > 0)
    encodeNumbers(coding, context, payload);
  codeResiduals(coding, models_.intensity, context);
  coding.coder().finish();
  return std::min(occupancy_bytes, payload.size() - begin);
}

/** \brief Codes the numbers, plain if that is smaller. */
template <typename CodingT>
void
Payload::encodeNumbers(CodingT& coding,
                       const FrameContext& context,
                       std::vector<std::uint8_t>& payload)
{
  std::vector<std::uint16_t>& numbers = intensities_.numbers;
  // The payload is copied, too, as a carry may change bytes already written.
  IntensityModels& models_before = trial_models_.intensity;
  models_before = models_.intensity;
  payload_before_.assign(payload.begin(), payload.end());
  const CodingT coding_before = coding;
  const auto run = [&](bool is_plain) {
    IntensityPass(coding, models_.intensity, frame_.directory, context)
        .run(blocks_, is_plain, numbers);
    return payload.size();
  };
  const auto undo = [&] {
    models_.intensity = models_before;
    payload.assign(payload_before_.begin(), payload_before_.end());
    coding = coding_before;
  };
  const std::size_t expected_size = run(false);
  // Plain coding is not tried if the result is below a quarter of the bits.
  const std::size_t bits = 8 * (expected_size - payload_before_.size());
  if (4 * bits < numbers.size() * context.symbol_bits)
    return;
  undo();
  if (run(true) < expected_size)
    return;
  undo();
  run(false);
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
  if (voxel_count == 0) {
    if (begin != end)
      return false;
    intensities_.numbers.clear();
    intensities_.symbols.clear();
    if (is_i_frame)
      trial_models_ = fresh_models_;
  }
  else {
    const FrameContext context = contextOf(frame, is_i_frame);
    if (!(is_mixing_ ? decodeWith<MixedContextCoding>(
                           context, begin, end, voxel_count, sizes.occupancy)
                     : decodeWith<SingleContextCoding>(
                           context, begin, end, voxel_count, sizes.occupancy)))
      return false;
  }
  sizes.intensity = static_cast<std::size_t>(end - begin) - sizes.occupancy;
  blocks_.voxelKeys(frame.keys);
  if (frame.hasIntensities())
    copyNumbers(intensities_.symbols, frame.intensities);
  prepareLearning(frame, is_i_frame);
  has_models_ = voxel_count != 0 || is_i_frame;
  return true;
}

template <template <typename> class CodingT>
bool
Payload::decodeWith(const FrameContext& context,
                    const std::uint8_t* begin,
                    const std::uint8_t* end,
                    std::size_t voxel_count,
                    std::size_t& occupancy_bytes)
{
  trial_models_ = context.is_i_frame ? fresh_models_ : models_;
  CodingT<BinaryRangeDecoder> coding{BinaryRangeDecoder(begin, end)};
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
  else if (!IntensityPass(coding, trial_models_.intensity, frame_.directory, context)
                .run(blocks_, false, intensities_.numbers))
    return false;
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
  return new_voxels.run();
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
Payload::prepareLearning(const VoxelFrame& frame, bool is_i_frame)
{
  symbol_bits_ = frame.intensity_scale.bits;
  is_i_frame_ = is_i_frame;
  has_depths_ = frame.depth_model && !frame.keys.empty();
  if (has_depths_)
    intensities_.split.observe(intensities_.numbers, intensities_.symbols, depths_);
  history_.makeRoom(blocks_, is_i_frame);
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
  if (is_i_frame_)
    history_.clear(symbol_bits_, forgotten_below_);
  history_.update(
      blocks_, intensities_.numbers, has_depths_ ? &depths_ : nullptr, is_i_frame_);
}

void
Payload::releaseMemory()
{
  history_.releaseMemory();
  blocks_ = BlockList();
  frame_ = Frame();
  intensities_ = CodedIntensities();
  depths_ = DepthObservations();
  payload_before_ = std::vector<std::uint8_t>();
}

} // namespace context
} // namespace io
} // namespace pcl_ext
