#include "context_coder.h"

#include "binary_range_coder.h"

#include <utility>

namespace pcl_ext {
namespace io {

namespace {

/** \brief Codes numbers and rests of a frame whose blocks are known. */
template <typename CodingT>
bool
codeIntensities(CodingT& coding,
                IntensityModels& models,
                const PayloadContext& context,
                const BlockList& frame,
                CodedIntensities& intensities)
{
  IntensityPass pass(coding, models, context.history, context.symbol_bits);
  if (!pass.run(frame, intensities.numbers))
    return false;
  if (CodingT::is_decoder)
    intensities.symbols = intensities.numbers;
  if (context.depth_model == nullptr)
    return true;
  if (CodingT::is_decoder)
    intensities.split.begin(
        *context.depth_model, frame, context.history, context.maxSymbol());
  intensities.split.predict(intensities.numbers);
  return pass.runRests(intensities.split, intensities.symbols);
}

} // namespace

std::size_t
ContextCoder::encode(const PayloadContext& context,
                     const BlockList& frame,
                     CodedIntensities& intensities,
                     std::vector<std::uint8_t>& payload)
{
  static const Models fresh_models;
  if (context.is_i_frame)
    models_ = fresh_models;
  const std::size_t begin = payload.size();
  BinaryRangeEncoder side(payload);
  SingleContextCoding coding(side);
  OccupancyPass occupancy(
      coding, models_.occupancy, workspace_, context, intensities.numbers.size());
  occupancy.run(&frame);
  const std::size_t occupancy_bytes = payload.size() - begin;
  codeIntensities(coding, models_.intensity, context, frame, intensities);
  side.finish();
  return occupancy_bytes;
}

bool
ContextCoder::decode(const PayloadContext& context,
                     const std::uint8_t* begin,
                     const std::uint8_t* end,
                     std::size_t voxel_count,
                     BlockList& frame,
                     CodedIntensities& intensities,
                     std::size_t& occupancy_bytes)
{
  static const Models fresh_models;
  trial_models_ = context.is_i_frame ? fresh_models : models_;
  BinaryRangeDecoder side(begin, end);
  SingleContextCoding coding(side);
  OccupancyPass occupancy(
      coding, trial_models_.occupancy, workspace_, context, voxel_count);
  if (!occupancy.run(nullptr))
    return false;
  occupancy.collect(frame);
  if (frame.voxelCount() != voxel_count)
    return false;
  occupancy_bytes = static_cast<std::size_t>(side.position() - begin);
  intensities.numbers.assign(voxel_count, 0);
  if (!codeIntensities(coding, trial_models_.intensity, context, frame, intensities) ||
      side.position() != end)
    return false;
  std::swap(models_, trial_models_);
  return true;
}

} // namespace io
} // namespace pcl_ext
