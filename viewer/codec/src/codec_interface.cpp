// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief C interface of the codec for WebAssembly: decoding, description and size of
 * frames, removal of outliers. Called by the TypeScript beside it only.
 *
 * Compiled for wasm32 without exceptions. Results lie in memory of this module and hold
 * until the next call. Where memory runs out the module traps, and must not be used
 * again: is_out_of_memory() then tells this from other traps.
 */
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/frame_description.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "outliers/outlier_setting_table.h"
#include "viewer/codec/src/decoded_fields.h"
#include "viewer/codec/src/result_layouts.h"
#include "viewer/codec/src/seekable_bytes.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#define EXPORTED(name) extern "C" __attribute__((export_name(#name)))

namespace {

using namespace pcl_ext;
using namespace pcl_ext::viewer;

/** \brief What the last call returned, and the memory that it lies in. */
struct Results {
  std::string message;
  std::string frame_id;
  std::unique_ptr<float[]> positions;
  std::unique_ptr<float[]> intensities;
  std::unique_ptr<std::uint8_t[]> colours;
  std::vector<std::uint8_t> is_noise;
  DecodedFields fields;
  FieldValues field_values;
  DecodedFrame decoded;
  DescribedFrame described;
  MeasuredFrame measured;
  Judgement judgement;
  VoxelOutlierRemovalSettings filter_settings;
  Outcome outcome;
};

Results&
results()
{
  static Results results;
  return results;
}

bool is_out_of_memory = false;

template <typename StatusT>
Outcome
outcomeOf(const StatusT& status)
{
  results().message = status.message();
  return {static_cast<std::uint32_t>(status.code()), spanOf(results().message)};
}

Grid
gridOf(const io::VoxelGrid& grid)
{
  Grid result;
  result.resolution = grid.resolution;
  std::copy(grid.origin.begin(), grid.origin.end(), result.origin);
  std::copy(grid.first_index.begin(), grid.first_index.end(), result.first_index);
  result.depth = grid.depth;
  return result;
}

Scale
scaleOf(const io::IntensityScale& scale)
{
  if (scale.bits == 0)
    return {};
  const auto highest = static_cast<std::uint16_t>(scale.maxSymbol());
  return {static_cast<double>(scale.value(0)),
          static_cast<double>(scale.value(highest)),
          static_cast<double>(scale.step),
          scale.bits,
          scale.companded_range};
}

/** \brief Limits for looking at frames without decoding them. */
io::DecoderLimits
limitsOf(std::uint32_t max_frame_bytes,
         std::uint32_t max_voxels,
         std::uint32_t max_points,
         std::uint32_t max_field_values)
{
  io::DecoderLimits limits = io::DecoderLimits::none();
  limits.max_frame_bytes = max_frame_bytes;
  limits.max_voxels = max_voxels;
  limits.max_points = max_points;
  limits.max_field_values = max_field_values;
  return limits;
}

/** \brief A decoder, and the frame that it decoded last. */
struct Decoder {
  explicit Decoder(const io::DecoderLimits& limits) : decoder(limits) {}

  io::FrameDecoder decoder;
  io::VoxelFrame frame;
  bool has_frame = false;
};

/** \brief Computes positions and intensities of a frame's voxels. */
void
setCentres(const io::VoxelFrame& frame)
{
  Results& result = results();
  result.positions.reset(new float[3 * frame.size()]);
  float* position = result.positions.get();
  if (!frame.hasIntensities()) {
    io::forEachVoxelCentre(frame, [&](float x, float y, float z, float) {
      position[0] = x;
      position[1] = y;
      position[2] = z;
      position += 3;
    });
    return;
  }
  result.intensities.reset(new float[frame.size()]);
  float* next_intensity = result.intensities.get();
  io::forEachVoxelCentre(frame, [&](float x, float y, float z, float intensity) {
    position[0] = x;
    position[1] = y;
    position[2] = z;
    position += 3;
    *next_intensity++ = intensity;
  });
}

void
setColours(const io::VoxelFrame& frame)
{
  if (frame.colour_bits == 0)
    return;
  results().colours.reset(new std::uint8_t[3 * frame.size()]);
  std::uint8_t* channel = results().colours.get();
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const io::VoxelColour colour = frame.fullColour(i);
    *channel++ = colour.r;
    *channel++ = colour.g;
    *channel++ = colour.b;
  }
}

void
describeVoxels(const Decoder& decoder, DecodedFrame& result)
{
  const io::VoxelFrame& frame = decoder.frame;
  setCentres(frame);
  setColours(frame);
  result.grid = gridOf(frame.grid);
  result.scale = scaleOf(frame.intensity_scale);
  result.voxels = static_cast<std::uint32_t>(frame.size());
  result.positions = addressOf(results().positions.get());
  result.intensities = addressOf(results().intensities.get());
  result.colours = addressOf(results().colours.get());
  result.keys = addressOf(frame.keys.data());
  if (frame.hasIntensities())
    result.symbols = addressOf(frame.intensities.data());
  if (frame.has_point_counts)
    result.point_counts = addressOf(frame.point_counts.data());
  results().fields.describe(frame, result);
  const auto& stamp = decoder.decoder.stamp();
  if (stamp) {
    results().frame_id = stamp->frame_id;
    result.stamp = {stamp->stamp, 1, spanOf(results().frame_id)};
  }
}

void
releaseArrays(Results& result)
{
  result.positions.reset();
  result.intensities.reset();
  result.colours.reset();
  result.fields.release();
}

} // namespace

/** \brief To be called once, before anything else. */
EXPORTED(set_up)
void
setUp()
{
  // Without exceptions operator new would return a null pointer.
  std::set_new_handler([] {
    is_out_of_memory = true;
    __builtin_trap();
  });
}

EXPORTED(is_out_of_memory)
std::uint32_t
isOutOfMemory()
{
  return is_out_of_memory ? 1 : 0;
}

/** \brief Memory for the bytes of a call. */
EXPORTED(allocate)
std::uint8_t*
allocate(std::uint32_t size)
{
  return new std::uint8_t[size];
}

EXPORTED(release)
void
release(const std::uint8_t* bytes)
{
  delete[] bytes;
}

EXPORTED(create_decoder)
Decoder*
createDecoder(std::uint32_t max_frame_bytes,
              std::uint32_t max_voxels,
              std::uint32_t max_points,
              std::uint32_t max_field_values)
{
  io::DecoderLimits limits =
      limitsOf(max_frame_bytes, max_voxels, max_points, max_field_values);
  limits.free_voxels = io::DecoderLimits().free_voxels;
  return new Decoder(limits);
}

EXPORTED(destroy_decoder)
void
destroyDecoder(const Decoder* decoder)
{
  delete decoder;
}

EXPORTED(decode)
const DecodedFrame*
decode(Decoder* decoder, const std::uint8_t* bytes, std::uint32_t size)
{
  Results& result = results();
  releaseArrays(result);
  DecodedFrame& decoded = result.decoded = {};
  SeekableBytes source(bytes, size);
  const auto status = decoder->decoder.decode(source, decoder->frame);
  decoded.bytes_read = static_cast<std::uint32_t>(source.position());
  decoder->has_frame = status.ok();
  decoded.outcome = outcomeOf(status);
  if (status.ok()) {
    const auto& statistics = decoder->decoder.statistics();
    decoded.frame_number = statistics.frame_number;
    decoded.is_i_frame = statistics.is_i_frame ? 1 : 0;
    decoded.bytes = static_cast<std::uint32_t>(statistics.bytes);
    decoded.skipped_bytes = static_cast<std::uint32_t>(statistics.skipped_bytes);
    describeVoxels(*decoder, decoded);
  }
  return &decoded;
}

/** \brief A value of a field for each voxel of the frame that a decoder decoded last;
 * null if it has none. */
EXPORTED(field_values)
const FieldValues*
fieldValues(const Decoder* decoder, std::uint32_t field, std::uint32_t value)
{
  if (!decoder->has_frame)
    return nullptr;
  results().field_values = results().fields.find(decoder->frame, field, value);
  return &results().field_values;
}

EXPORTED(describe_frame)
const DescribedFrame*
describeFrame(const std::uint8_t* bytes,
              std::uint32_t size,
              std::uint32_t max_frame_bytes,
              std::uint32_t max_voxels,
              std::uint32_t max_points,
              std::uint32_t max_field_values)
{
  const io::FrameDescription description = io::describeFrame(
      bytes, size, limitsOf(max_frame_bytes, max_voxels, max_points, max_field_values));
  DescribedFrame& described = results().described = {};
  described.outcome = outcomeOf(description.status);
  described.grid = gridOf(description.grid);
  described.scale = scaleOf(description.intensity_scale);
  described.stamp.stamp = description.stamp.value_or(0);
  described.stamp.has_stamp = description.stamp.has_value() ? 1 : 0;
  described.has_frame_id = description.frame_id.has_value() ? 1 : 0;
  results().frame_id = description.frame_id.value_or("");
  described.stamp.frame_id = spanOf(results().frame_id);
  described.stamp_difference = description.stamp_difference.value_or(0);
  described.has_stamp_difference = description.stamp_difference.has_value() ? 1 : 0;
  described.is_published = description.format == io::StreamFormat::Published ? 1 : 0;
  described.effort = static_cast<std::uint32_t>(description.effort);
  described.frame_number = description.frame_number;
  described.is_i_frame = description.is_i_frame ? 1 : 0;
  described.voxels = static_cast<std::uint32_t>(description.voxels);
  described.points = static_cast<std::uint32_t>(description.points);
  described.colour_bits = description.colour_bits;
  described.has_point_counts = description.has_point_counts ? 1 : 0;
  described.has_points = description.has_points ? 1 : 0;
  return &described;
}

EXPORTED(frame_size)
const MeasuredFrame*
frameSize(const std::uint8_t* bytes,
          std::uint32_t size,
          std::uint32_t max_frame_bytes,
          std::uint32_t max_voxels,
          std::uint32_t max_points,
          std::uint32_t max_field_values)
{
  const io::FrameSize measured = io::frameSize(
      bytes, size, limitsOf(max_frame_bytes, max_voxels, max_points, max_field_values));
  results().measured = {outcomeOf(measured.status),
                        static_cast<std::uint32_t>(measured.known + measured.drop)};
  return &results().measured;
}

/** \brief Sets the unit of the next filter, with default settings. */
EXPORTED(set_filter_unit)
void
setFilterUnit(std::uint32_t unit)
{
  results().filter_settings = {densityUnitSettings(static_cast<DensityUnit>(unit))};
}

/** \brief Sets one of its settings, a number or three of them.
 * \param[in] name that of the field
 */
EXPORTED(set_filter_setting)
const Outcome*
setFilterSetting(const char* name, std::uint32_t size, double x, double y, double z)
{
  VoxelOutlierRemovalSettings& settings = results().filter_settings;
  bool is_found = false;
  visitSettings(settings, [&](const OutlierSetting& setting, auto& value) {
    using ValueT = std::decay_t<decltype(value)>;
    if (std::string_view(name, size) != setting.name)
      return;
    is_found = true;
    if constexpr (std::is_arithmetic_v<ValueT>)
      value = static_cast<ValueT>(x);
    else
      value = {x, y, z};
  });
  results().outcome =
      outcomeOf(is_found ? checkSettings(settings)
                         : OutlierRemovalStatus(
                               OutlierRemovalCode::InvalidSettings,
                               std::string(name, size) + " is set; the unit " +
                                   nameOf(density_units, densityUnitOf(settings.unit)) +
                                   " does not have it"));
  return &results().outcome;
}

EXPORTED(create_outlier_filter)
VoxelOutlierRemoval*
createOutlierFilter()
{
  return new VoxelOutlierRemoval(results().filter_settings);
}

EXPORTED(destroy_outlier_filter)
void
destroyOutlierFilter(const VoxelOutlierRemoval* filter)
{
  delete filter;
}

EXPORTED(reset_outlier_filter)
void
resetOutlierFilter(VoxelOutlierRemoval* filter)
{
  filter->reset();
}

/** \brief Judges the frame that a decoder decoded last; null if it has none. */
EXPORTED(judge)
const Judgement*
judge(VoxelOutlierRemoval* filter, const Decoder* decoder)
{
  if (!decoder->has_frame)
    return nullptr;
  const io::VoxelFrame& frame = decoder->frame;
  io::VoxelFrame kept = frame;
  const OutlierRemovalStatus status = filter->filter(kept);
  std::vector<std::uint8_t>& is_noise = results().is_noise;
  is_noise.assign(frame.size(), 1);
  // Both are in the order of the keys.
  std::size_t next = 0;
  for (std::size_t i = 0; i < frame.size(); ++i)
    if (next < kept.size() && frame.keys[i] == kept.keys[next]) {
      is_noise[i] = 0;
      ++next;
    }
  results().judgement = {outcomeOf(status),
                         static_cast<std::uint32_t>(frame.size()),
                         addressOf(is_noise.data())};
  return &results().judgement;
}
