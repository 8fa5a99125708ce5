#include "codec/context/coder.h"

#include "codec/context/entropy_coder.h"

#include <algorithm>

namespace pcl_ext {
namespace io {
namespace context {

namespace {

/** \brief Codes the rests of a frame whose numbers are known. */
template <typename CodingT>
bool
codeRests(CodingT& coding,
          IntensityModels& models,
          BlockDirectory& directory,
          const FrameContext& context,
          CodedIntensities& intensities)
{
  if (context.depth_model == nullptr)
    return true;
  intensities.split.predict(intensities.numbers);
  return IntensityPass(coding, models, directory, context)
      .runRests(intensities.split, intensities.symbols);
}

} // namespace

FrameCoder::FrameCoder(bool is_mixing)
: is_mixing_(is_mixing)
, fresh_models_(is_mixing)
, models_(fresh_models_)
, trial_models_(fresh_models_)
{}

template <typename CodingT>
bool
FrameCoder::codeOccupancy(CodingT& coding,
                          Models& models,
                          const FrameContext& context,
                          const BlockList* frame,
                          std::size_t max_voxels)
{
  workspace_.begin(context.history, frame);
  KnownVoxelPass known_voxels(coding, models.known_voxels, workspace_, context);
  const std::size_t voxels = known_voxels.run();
  if (voxels > max_voxels)
    return false;
  NewVoxelPass new_voxels(
      coding, models.new_voxels, workspace_, context, max_voxels - voxels);
  return new_voxels.run();
}

template <typename CodingT>
void
FrameCoder::encodeNumbers(CodingT& coding,
                          const FrameContext& context,
                          const BlockList& frame,
                          std::vector<std::uint16_t>& numbers,
                          std::vector<std::uint8_t>& payload)
{
  // The payload so far, too, as a carry may run back into it.
  IntensityModels& models_before = trial_models_.intensity;
  models_before = models_.intensity;
  payload_before_.assign(payload.begin(), payload.end());
  const CodingT coding_before = coding;
  const auto run = [&](bool is_plain) {
    IntensityPass(coding, models_.intensity, workspace_.directory, context)
        .run(frame, is_plain, numbers);
    return payload.size();
  };
  const auto undo = [&] {
    models_.intensity = models_before;
    payload.assign(payload_before_.begin(), payload_before_.end());
    coding = coding_before;
  };
  const std::size_t expected_size = run(false);
  // Numbers for which expectations cost more than they save cost a quarter of their bits
  // at least.
  const std::size_t bits = 8 * (expected_size - payload_before_.size());
  if (4 * bits < numbers.size() * context.symbol_bits)
    return;
  undo();
  if (run(true) < expected_size)
    return;
  undo();
  run(false);
}

template <template <typename> class CodingT>
std::size_t
FrameCoder::encodeWith(const FrameContext& context,
                       const BlockList& frame,
                       CodedIntensities& intensities,
                       std::vector<std::uint8_t>& payload)
{
  if (context.is_i_frame)
    models_ = fresh_models_;
  const std::size_t begin = payload.size();
  CodingT<BinaryRangeEncoder> coding{BinaryRangeEncoder(payload)};
  codeOccupancy(coding, models_, context, &frame, intensities.numbers.size());
  const std::size_t occupancy_bytes = coding.side().settledBytes();
  encodeNumbers(coding, context, frame, intensities.numbers, payload);
  codeRests(coding, models_.intensity, workspace_.directory, context, intensities);
  coding.side().finish();
  return std::min(occupancy_bytes, payload.size() - begin);
}

template <template <typename> class CodingT>
bool
FrameCoder::decodeWith(const FrameContext& context,
                       const std::uint8_t* begin,
                       const std::uint8_t* end,
                       std::size_t voxel_count,
                       BlockList& frame,
                       CodedIntensities& intensities,
                       std::size_t& occupancy_bytes)
{
  trial_models_ = context.is_i_frame ? fresh_models_ : models_;
  CodingT<BinaryRangeDecoder> coding{BinaryRangeDecoder(begin, end)};
  if (!codeOccupancy(coding, trial_models_, context, nullptr, voxel_count))
    return false;
  workspace_.collect(context.history, frame);
  if (frame.voxelCount() != voxel_count)
    return false;
  occupancy_bytes =
      std::min(coding.side().settledBytes(), static_cast<std::size_t>(end - begin));
  intensities.numbers.resize(voxel_count); // of any value, as all are decoded
  IntensityPass numbers(coding, trial_models_.intensity, workspace_.directory, context);
  if (!numbers.run(frame, false, intensities.numbers))
    return false;
  copyNumbers(intensities.numbers, intensities.symbols);
  if (context.depth_model != nullptr)
    intensities.split.begin(
        *context.depth_model, frame, context.history, context.maxSymbol());
  return codeRests(coding,
                   trial_models_.intensity,
                   workspace_.directory,
                   context,
                   intensities) &&
         coding.side().isAtEnd();
}

std::size_t
FrameCoder::encode(const FrameContext& context,
                   const BlockList& frame,
                   CodedIntensities& intensities,
                   std::vector<std::uint8_t>& payload)
{
  return is_mixing_
             ? encodeWith<MixedContextCoding>(context, frame, intensities, payload)
             : encodeWith<SingleContextCoding>(context, frame, intensities, payload);
}

bool
FrameCoder::decode(const FrameContext& context,
                   const std::uint8_t* begin,
                   const std::uint8_t* end,
                   std::size_t voxel_count,
                   BlockList& frame,
                   CodedIntensities& intensities,
                   std::size_t& occupancy_bytes)
{
  return is_mixing_ ? decodeWith<MixedContextCoding>(context,
                                                     begin,
                                                     end,
                                                     voxel_count,
                                                     frame,
                                                     intensities,
                                                     occupancy_bytes)
                    : decodeWith<SingleContextCoding>(context,
                                                      begin,
                                                      end,
                                                      voxel_count,
                                                      frame,
                                                      intensities,
                                                      occupancy_bytes);
}

} // namespace context
} // namespace io
} // namespace pcl_ext
