// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/context/payload.h"

#include "codec/context/entropy_coder.h"
#include "codec/point_symbols.h"

#include <algorithm>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

namespace {

/** \brief Divides a payload by what it codes.
 * \param[in] bytes of the payload
 * \param[in] occupancy_end bytes before the intensities
 * \param[in] intensity_end bytes before numbers of points beside intensities
 */
PayloadSizes
dividedSizes(const VoxelFrame& frame,
             std::size_t bytes,
             std::size_t occupancy_end,
             std::size_t intensity_end)
{
  const std::size_t point_begin = !frame.has_point_counts  ? bytes
                                  : frame.hasIntensities() ? intensity_end
                                                           : occupancy_end;
  PayloadSizes sizes;
  sizes.occupancy = std::min(occupancy_end, bytes);
  sizes.attributes = bytes - std::min(point_begin, bytes);
  sizes.intensity = bytes - sizes.occupancy - sizes.attributes;
  return sizes;
}

template <typename CodingT>
HistoryPart
codePart(CodingT& coding, HistoryPart part)
{
  return codeHistoryPart([&](bool bit) { return coding.codeBypass(bit); }, part);
}

} // namespace

Payload::Payload(bool is_small)
: is_small_(is_small)
, models_(freshModels(is_small, false))
, trial_models_(freshModels(is_small, false))
{}

const Payload::Models&
Payload::freshModels(bool is_small, bool has_points)
{
  // Each is made when it is first used.
  if (is_small && has_points) {
    static const Models models(true, true);
    return models;
  }
  if (is_small) {
    static const Models models(true, false);
    return models;
  }
  if (has_points) {
    static const Models models(false, true);
    return models;
  }
  static const Models models(false, false);
  return models;
}

FrameParameters
Payload::parametersOf(const VoxelFrame& frame, bool uses_history)
{
  const unsigned int symbol_bits = firstSymbolBits(frame);
  empty_history_.clear(symbol_bits);
  return {uses_history ? history_ : empty_history_,
          frame.grid.depth,
          symbol_bits,
          frame.depth_model ? &*frame.depth_model : nullptr};
}

/** \brief Begins with the depth model of a frame whose blocks are coded. */
void
Payload::splitByDepth(const FrameParameters& parameters)
{
  parameters.history.predictDepths(blocks_, intensities_.predictions);
  intensities_.split.begin(*parameters.depth_model,
                           blocks_,
                           intensities_.predictions,
                           parameters.maxSymbol());
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
  PayloadSizes sizes;
  const auto encode_as = [&](HistoryPart part) {
    payload.resize(begin);
    sizes = encodeAs(frame, is_i_frame, part, payload);
    return payload.size() - begin;
  };
  HistoryPart part = HistoryPart::Replaced;
  if (is_i_frame) {
    history_use_.measureIFrame(voxels, encode_as(part));
    history_use_.addIFrame();
  }
  else
    part = encodePFrame(voxels, encode_as);
  prepareLearning(frame, part);
  learnHistory();
  return sizes;
}

/** \brief Encodes a P-frame with or without the history, whichever is smaller.
 * \param[in] encode_as encodes the frame anew and returns its bytes
 */
template <typename EncodeT>
HistoryPart
Payload::encodePFrame(std::size_t voxels, const EncodeT& encode_as)
{
  if (voxels == 0) {
    encode_as(HistoryPart::Used);
    return HistoryPart::Used;
  }
  HistoryPart encoded = HistoryPart::Replaced;
  const auto encode = [&](HistoryPart part) {
    if (part == HistoryPart::Used)
      trial_models_ = models_;
    else if (encoded == HistoryPart::Used)
      models_ = trial_models_;
    encoded = part;
    return encode_as(part);
  };
  const HistoryPart part = history_use_.choose(voxels, encode);
  if (part != encoded) {
    models_ = trial_models_;
    encode_as(part);
  }
  return part;
}

/** \brief Encodes a frame with or without the history, and adapts the models. */
PayloadSizes
Payload::encodeAs(const VoxelFrame& frame,
                  bool is_i_frame,
                  HistoryPart part,
                  std::vector<std::uint8_t>& payload)
{
  const bool uses_history = part == HistoryPart::Used;
  const FrameParameters parameters = parametersOf(frame, uses_history);
  if (is_i_frame)
    models_ = freshModels(is_small_, hasPointsBesideIntensities(frame));
  if (!uses_history || !is_matched_) {
    blocks_.assign(frame.keys);
    frame_.match(parameters.history, blocks_);
  }
  is_matched_ = false;
  if (frame.has_point_counts)
    pointSymbolsOf(frame.point_counts, intensities_.point_symbols);
  if (frame.hasIntensities())
    copySymbols(frame.intensities, intensities_.symbols);
  else if (frame.has_point_counts)
    copySymbols(intensities_.point_symbols, intensities_.symbols);
  else
    intensities_.symbols.assign(frame.size(), 0);
  if (parameters.depth_model != nullptr) {
    splitByDepth(parameters);
    intensities_.split.baseSymbolsOf(intensities_.symbols, intensities_.base_symbols);
  }
  else
    copySymbols(intensities_.symbols, intensities_.base_symbols);
  if (frame.keys.empty())
    return {};
  return is_small_ ? encodeWith<true>(frame, parameters, is_i_frame, part, payload)
                   : encodeWith<false>(frame, parameters, is_i_frame, part, payload);
}

template <bool IsSmall>
PayloadSizes
Payload::encodeWith(const VoxelFrame& frame,
                    const FrameParameters& parameters,
                    bool is_i_frame,
                    HistoryPart part,
                    std::vector<std::uint8_t>& payload)
{
  const std::size_t begin = payload.size();
  DecisionCoding<BinaryRangeEncoder, IsSmall> coding{BinaryRangeEncoder(payload)};
  if (!is_i_frame)
    codePart(coding, part);
  codeOccupancy(coding, models_, parameters, intensities_.base_symbols.size());
  const std::size_t occupancy_bytes = coding.coder().settledBytes();
  if (parameters.symbol_bits > 0)
    IntensityPass(coding, models_.intensity, frame_.directory, parameters)
        .run(blocks_, intensities_.base_symbols);
  codeResiduals(coding, models_.intensity, parameters);
  const std::size_t intensity_end = coding.coder().settledBytes();
  codePoints(coding, models_, parameters, frame);
  coding.coder().finish();
  return dividedSizes(frame, payload.size() - begin, occupancy_bytes, intensity_end);
}

bool
Payload::decode(CodingWorkspace& /*memory*/,
                const CodedPayload& payload,
                VoxelFrame& frame,
                PayloadSizes& sizes)
{
  sizes = PayloadSizes();
  blocks_.clear();
  history_part_ = payload.is_i_frame ? HistoryPart::Replaced : HistoryPart::Used;
  if (payload.voxel_count == 0) {
    if (payload.begin != payload.end)
      return false;
    intensities_.base_symbols.clear();
    intensities_.symbols.clear();
    intensities_.point_symbols.clear();
    frame.point_counts.clear();
    if (payload.is_i_frame)
      trial_models_ = freshModels(is_small_, hasPointsBesideIntensities(frame));
  }
  else if (!(is_small_ ? decodeWith<true>(payload, frame, sizes)
                       : decodeWith<false>(payload, frame, sizes)))
    return false;
  blocks_.voxelKeys(frame_.octants, frame.keys);
  if (frame.hasIntensities())
    copySymbols(intensities_.symbols, frame.intensities);
  prepareLearning(frame, history_part_);
  has_models_ = payload.voxel_count != 0 || payload.is_i_frame;
  return true;
}

template <bool IsSmall>
bool
Payload::decodeWith(const CodedPayload& payload, VoxelFrame& frame, PayloadSizes& sizes)
{
  const bool is_i_frame = payload.is_i_frame;
  const std::size_t voxel_count = payload.voxel_count;
  trial_models_ =
      is_i_frame ? freshModels(is_small_, hasPointsBesideIntensities(frame)) : models_;
  DecisionCoding<BinaryRangeDecoder, IsSmall> coding{
      BinaryRangeDecoder(payload.begin, payload.end)};
  history_part_ =
      is_i_frame ? HistoryPart::Replaced : codePart(coding, HistoryPart::Replaced);
  const FrameParameters parameters =
      parametersOf(frame, history_part_ == HistoryPart::Used);
  frame_.begin(parameters.history);
  if (!codeOccupancy(
          coding, trial_models_, parameters, voxel_count, payload.max_blocks)) {
    sizes.has_too_many_blocks = has_too_many_blocks_;
    return false;
  }
  frame_.collect(parameters.history, blocks_);
  if (blocks_.voxelCount() != voxel_count)
    return false;
  const std::size_t occupancy_bytes = coding.coder().settledBytes();
  intensities_.base_symbols.resize(voxel_count);
  if (parameters.symbol_bits == 0)
    std::fill(intensities_.base_symbols.begin(), intensities_.base_symbols.end(), 0);
  else
    IntensityPass(coding, trial_models_.intensity, frame_.directory, parameters)
        .run(blocks_, intensities_.base_symbols);
  copySymbols(intensities_.base_symbols, intensities_.symbols);
  if (parameters.depth_model != nullptr)
    splitByDepth(parameters);
  if (!codeResiduals(coding, trial_models_.intensity, parameters))
    return false;
  sizes = dividedSizes(frame,
                       static_cast<std::size_t>(payload.end - payload.begin),
                       occupancy_bytes,
                       coding.coder().settledBytes());
  return codePoints(coding, trial_models_, parameters, frame) &&
         coding.coder().isAtEnd();
}

/** \brief Codes which voxels are occupied.
 * \return false if more than max_voxels, or more new blocks than max_blocks
 */
template <typename CodingT>
bool
Payload::codeOccupancy(CodingT& coding,
                       Models& models,
                       const FrameParameters& parameters,
                       std::size_t max_voxels,
                       std::size_t max_blocks)
{
  has_too_many_blocks_ = false;
  TrackedVoxelPass tracked_voxels(coding, models.tracked_voxels, frame_, parameters);
  const std::size_t voxels = tracked_voxels.run();
  if (voxels > max_voxels)
    return false;
  NewVoxelPass new_voxels(
      coding, models.new_voxels, frame_, parameters, max_voxels - voxels);
  if (!new_voxels.run())
    return false;
  NewBlockPass new_blocks(coding,
                          models.children,
                          frame_,
                          parameters,
                          max_voxels - voxels - new_voxels.voxelCount(),
                          max_blocks);
  const bool is_coded = new_blocks.run();
  has_too_many_blocks_ = new_blocks.hasTooManyBlocks();
  return is_coded;
}

/** \brief Codes the residuals of a depth model, if there is one, after the base
 * symbols. */
template <typename CodingT>
bool
Payload::codeResiduals(CodingT& coding,
                       IntensityContexts& models,
                       const FrameParameters& parameters)
{
  if (parameters.depth_model == nullptr)
    return true;
  intensities_.split.predict(intensities_.base_symbols);
  return IntensityPass(coding, models, frame_.directory, parameters)
      .codeResiduals(intensities_.split, intensities_.symbols);
}

/** \brief Codes numbers of points: their symbols, if those were not the first ones, and
 * what they have beyond these. */
template <typename CodingT, class FrameT>
bool
Payload::codePoints(CodingT& coding,
                    Models& models,
                    const FrameParameters& parameters,
                    FrameT& frame)
{
  if (!frame.has_point_counts)
    return true;
  const bool is_beside = frame.hasIntensities();
  const FrameParameters point_parameters{
      parameters.history, parameters.grid_depth, point_symbol_bits, nullptr};
  IntensityPass pass(coding,
                     is_beside ? *models.points : models.intensity,
                     frame_.directory,
                     point_parameters);
  std::vector<std::uint16_t>& symbols =
      is_beside ? intensities_.point_symbols : intensities_.symbols;
  symbols.resize(blocks_.voxelCount());
  if (is_beside)
    pass.run(blocks_, symbols, parameters.history.pointRecords());
  if constexpr (CodingT::is_decoder)
    frame.point_counts.assign(symbols.begin(), symbols.end());
  return pass.codeExcess(frame.point_counts);
}

/** \brief Stores what learnHistory() needs of a frame. */
void
Payload::prepareLearning(const VoxelFrame& frame, HistoryPart part)
{
  symbol_bits_ = firstSymbolBits(frame);
  has_points_ = hasPointsBesideIntensities(frame);
  history_part_ = part;
  has_depths_ = frame.depth_model && !frame.keys.empty();
  if (has_depths_)
    intensities_.split.observe(
        intensities_.base_symbols, intensities_.symbols, depths_);
  history_.makeRoom(blocks_, has_depths_, part == HistoryPart::Replaced, has_points_);
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
  const bool is_replaced = history_part_ == HistoryPart::Replaced;
  if (is_replaced)
    history_.clear(symbol_bits_);
  history_.update(blocks_,
                  intensities_.base_symbols,
                  has_depths_ ? &depths_ : nullptr,
                  is_replaced,
                  has_points_ ? &intensities_.point_symbols : nullptr);
}

void
Payload::releaseMemory()
{
  history_.releaseMemory();
  blocks_ = BlockList();
  frame_ = FrameBlocks();
  intensities_ = CodedIntensities();
  depths_ = DepthObservations();
}

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io
