// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/version1_header.h"

#include "bytes/byte_source.h"
#include "bytes/byte_writer.h"
#include "bytes/checksum.h"
#include "bytes/reserve_ahead.h"
#include "codec/frame_failures.h"
#include "stream/field_table.h"
#include "voxels/grid_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

constexpr std::uint8_t version = 1;
constexpr std::size_t checksum_end = version1_magic_size + 1 + 4;
// Of most frames, without the frame_id.
constexpr std::size_t usual_header_bytes = 160;

enum Flag : std::uint8_t {
  i_frame_flag = 1,
  depth_model_flag = 2,
  stamp_flag = 4,
  frame_id_flag = 8,
  origin_flag = 64,  // of an I-frame
  changes_flag = 64, // of a P-frame
  content_flag = 128
};

// In the field that describes the content; below them are the levels of the refinement.
enum ContentFlag : std::uint16_t {
  colours_flag = 32,
  point_counts_flag = 64,
  no_intensities_flag = 128,
  fields_flag = 256,
  scan_flag = 512,
  placement_flag = 1024, // of a P-frame
  layout_flag = 2048,    // of an I-frame
  padding_flag = 4096    // likewise
};
constexpr std::uint64_t known_content = 8191;

// Set in the number of bits of a companded scale, whose range follows.
constexpr std::uint8_t companded_flag = 0x80;

// The effort is between the flags, in two bits.
constexpr unsigned int effort_shift = 4;
constexpr unsigned int effort_mask = 3;

bool
hasOrigin(const Version1Header& header)
{
  return header.grid.origin != VoxelGrid().origin;
}

/** \brief The field that describes the content; 0: intensities only. */
unsigned int
contentFieldOf(const Version1Header& header)
{
  unsigned int field = header.content.refinement_levels;
  if (header.content.colour_bits > 0)
    field |= colours_flag;
  if (header.content.has_point_counts)
    field |= point_counts_flag;
  if (header.is_i_frame && header.intensity_scale.bits == 0)
    field |= no_intensities_flag;
  if (header.content.has_fields)
    field |= fields_flag;
  if (header.content.has_scan)
    field |= scan_flag;
  if (header.placement)
    field |= placement_flag;
  if (header.is_i_frame && header.layout)
    field |= layout_flag;
  if (header.padding_size > 0)
    field |= padding_flag;
  return field;
}

std::uint8_t
flagsOf(const Version1Header& header)
{
  int flags = static_cast<int>(header.effort) << effort_shift;
  flags |= header.is_i_frame ? i_frame_flag : 0;
  flags |= header.has_depth_model ? depth_model_flag : 0;
  flags |= header.stamp ? stamp_flag : 0;
  flags |= header.has_frame_id ? frame_id_flag : 0;
  flags |= header.is_i_frame && hasOrigin(header) ? origin_flag : 0;
  flags |= header.is_of_changes ? changes_flag : 0;
  flags |= contentFieldOf(header) != 0 ? content_flag : 0;
  return static_cast<std::uint8_t>(flags);
}

/** \brief Resets a header, but keeps the memory of the frame_id. */
void
clear(Version1Header& header)
{
  std::string frame_id = std::move(header.frame_id);
  frame_id.clear();
  header = Version1Header();
  header.frame_id = std::move(frame_id);
}

void
writeIntensityScale(const IntensityScale& scale, ByteWriter& writer)
{
  writer.f32(scale.offset);
  writer.f32(scale.step);
  const bool is_companded = scale.companded_range != 0;
  writer.u8(
      static_cast<std::uint8_t>(scale.bits | (is_companded ? companded_flag : 0)));
  if (is_companded)
    writer.u16(static_cast<std::uint16_t>(scale.companded_range));
}

void
writeFields(const Version1Header& header, ByteWriter& writer)
{
  writer.u8(flagsOf(header));
  writer.u32(header.frame_number);
  if (contentFieldOf(header) != 0)
    writer.varint(contentFieldOf(header));
  if (header.is_i_frame) {
    writer.f64(header.grid.resolution);
    for (const std::int32_t index : header.grid.first_index)
      writer.i32(index);
    writer.u8(static_cast<std::uint8_t>(header.grid.depth));
    if (hasOrigin(header))
      for (const double coordinate : header.grid.origin)
        writer.f64(coordinate);
    if (header.content.colour_bits > 0)
      writer.u8(static_cast<std::uint8_t>(header.content.colour_bits));
    if (header.intensity_scale.bits > 0)
      writeIntensityScale(header.intensity_scale, writer);
    if (header.content.has_fields)
      writeFieldTable(header.fields, header.viewpoint, writer);
    if (header.content.has_scan)
      writeScanTable(header.scan, writer);
    if (header.layout)
      writeLayout(*header.layout, writer);
  }
  if (header.placement)
    writeScanPlacement(*header.placement, writer);
  if (header.stamp && header.is_i_frame)
    writer.u64(static_cast<std::uint64_t>(*header.stamp));
  else if (header.stamp)
    writer.signedVarint(*header.stamp);
  if (header.has_frame_id) {
    writer.varint(header.frame_id.size());
    writer.raw(header.frame_id.data(), header.frame_id.size());
  }
  if (!header.content.has_scan)
    writer.varint(header.voxel_count);
  if (header.content.refinement_levels > 0)
    writer.varint(header.coarse_voxel_count);
  if (header.content.has_point_counts)
    writer.varint(header.point_count);
  writer.varint(header.payload_size);
  if (header.content.hasSupplement())
    writer.varint(header.supplement_size);
  if (header.padding_size > 0)
    writer.varint(header.padding_size);
}

CompressionStatus
readGrid(ByteSource& source, bool has_origin, VoxelGrid& grid)
{
  grid = VoxelGrid();
  grid.resolution = source.f64();
  for (std::int32_t& index : grid.first_index)
    index = source.i32();
  grid.depth = source.u8();
  for (std::size_t axis = 0; has_origin && axis < 3; ++axis)
    grid.origin[axis] = source.f64();
  if (source.failure() != ByteSource::Failure::None)
    return {};
  if (CompressionStatus status = checkResolution(grid.resolution); !status.ok())
    return status;
  if (grid.depth < 1 || grid.depth > max_grid_depth)
    return corruptFrame("grid depth outside 1 to 21");
  if (leavesLattice(grid))
    return corruptFrame("grid outside the lattice");
  if (has_origin && (!isOrigin(grid.origin) || grid.origin == VoxelGrid().origin))
    return corruptFrame("invalid origin");
  return {};
}

CompressionStatus
readIntensityScale(ByteSource& source, IntensityScale& scale)
{
  scale.offset = source.f32();
  scale.step = source.f32();
  const std::uint8_t bits = source.u8();
  const bool is_companded = (bits & companded_flag) != 0;
  scale.bits = bits & ~companded_flag;
  scale.companded_range = is_companded ? source.u16() : 0;
  if (source.failure() == ByteSource::Failure::None &&
      (!std::isfinite(scale.offset) || !std::isfinite(scale.step) ||
       !(scale.step > 0.0f) || scale.bits < 1 || scale.bits > 16))
    return corruptFrame("invalid intensity scale");
  // A scale whose levels are single numbers has to be written as linear.
  if (source.failure() == ByteSource::Failure::None && is_companded &&
      scale.companded_range <= scale.maxSymbol())
    return corruptFrame("companded scale with too small a range");
  return {};
}

CompressionStatus
readFrameId(ByteSource& source, std::string& frame_id)
{
  const std::uint64_t size = source.varint();
  if (source.failure() == ByteSource::Failure::None && size > max_frame_id_size)
    return corruptFrame("frame_id too long");
  source.text(size, frame_id);
  return {};
}

CompressionStatus
readContent(ByteSource& source, Version1Header& header)
{
  const std::uint64_t field = source.varint();
  header.content.refinement_levels =
      static_cast<unsigned int>(field & (colours_flag - 1u));
  header.content.has_point_counts = (field & point_counts_flag) != 0;
  header.content.colour_bits = (field & colours_flag) != 0 ? 1 : 0; // I: follow
  header.content.has_fields = (field & fields_flag) != 0;           // likewise
  header.content.has_scan = (field & scan_flag) != 0;               // likewise
  if ((field & placement_flag) != 0)
    header.placement.emplace();
  if ((field & no_intensities_flag) != 0)
    header.intensity_scale.bits = 0;
  if ((field & layout_flag) != 0)
    header.layout = std::make_shared<MessageLayout>();       // follows
  header.padding_size = (field & padding_flag) != 0 ? 1 : 0; // likewise
  if (source.failure() == ByteSource::Failure::None &&
      (field == 0 || (field & ~known_content) != 0 ||
       header.content.refinement_levels >= max_grid_depth ||
       (header.content.has_scan &&
        (!header.content.has_point_counts || header.content.refinement_levels > 0 ||
         header.has_depth_model)) ||
       (!header.is_i_frame && (header.intensity_scale.bits == 0 || header.layout ||
                               header.padding_size > 0)) ||
       (header.placement && (header.is_i_frame || !header.content.has_scan))))
    return corruptFrame("invalid content");
  return {};
}

/** \brief Reads the fields of an I-frame only, except for the stamp. */
CompressionStatus
readIFrameFields(ByteSource& source, std::uint8_t flags, Version1Header& header)
{
  if (CompressionStatus status =
          readGrid(source, (flags & origin_flag) != 0, header.grid);
      !status.ok())
    return status;
  if (header.content.refinement_levels >= header.grid.depth &&
      source.failure() == ByteSource::Failure::None)
    return corruptFrame("coarse voxels larger than the grid");
  if (header.content.colour_bits > 0) {
    header.content.colour_bits = source.u8();
    if (source.failure() == ByteSource::Failure::None &&
        (header.content.colour_bits < 1 || header.content.colour_bits > 8))
      return corruptFrame("bits of a colour outside 1 to 8");
  }
  if (header.intensity_scale.bits > 0)
    if (CompressionStatus status = readIntensityScale(source, header.intensity_scale);
        !status.ok())
      return status;
  if (header.content.has_fields)
    if (CompressionStatus status =
            readFieldTable(source, header.fields, header.viewpoint);
        !status.ok())
      return status;
  if (header.content.has_scan)
    if (CompressionStatus status = readScanTable(source, header.scan); !status.ok())
      return status;
  if (!header.layout)
    return {};
  auto layout = std::make_shared<MessageLayout>();
  CompressionStatus status = readLayout(source, *layout);
  header.layout = std::move(layout);
  return status;
}

/** \brief Reads how much of what there is. */
void
readCounts(ByteSource& source, Version1Header& header)
{
  if (!header.content.has_scan)
    header.voxel_count = source.varint();
  if (header.content.refinement_levels > 0)
    header.coarse_voxel_count = source.varint();
  if (header.content.has_point_counts)
    header.point_count = source.varint();
  // At most.
  if (header.content.has_scan)
    header.voxel_count = header.point_count;
  header.payload_size = source.varint();
  if (header.content.hasSupplement())
    header.supplement_size = source.varint();
  if (header.padding_size > 0)
    header.padding_size = source.varint();
}

CompressionStatus
readFields(ByteSource& source, std::uint8_t flags, Version1Header& header)
{
  header.frame_number = source.u32();
  CompressionStatus status;
  if ((flags & content_flag) != 0)
    status = readContent(source, header);
  if (status.ok() && header.is_i_frame)
    status = readIFrameFields(source, flags, header);
  if (status.ok() && header.placement)
    readScanPlacement(source, *header.placement);
  if (status.ok() && (flags & stamp_flag) != 0)
    header.stamp = header.is_i_frame ? static_cast<std::int64_t>(source.u64())
                                     : source.signedVarint();
  header.has_frame_id = (flags & frame_id_flag) != 0;
  if (status.ok() && header.has_frame_id)
    status = readFrameId(source, header.frame_id);
  readCounts(source, header);
  return status;
}

/** \brief Checks the fields that do not depend on the payload. */
CompressionStatus
checkFields(const Version1Header& header,
            const DecoderLimits& decoder_limits,
            std::uint64_t bytes_before)
{
  if (header.payload_size > decoder_limits.max_frame_bytes)
    return {CompressionCode::LimitExceeded,
            "frame header: payload exceeds the limit of " +
                std::to_string(decoder_limits.max_frame_bytes) + " bytes"};
  const FrameLimits limits = limitsOf(header, decoder_limits, bytes_before);
  const char* const what = header.content.has_scan ? "points in order" : "voxels";
  if (CompressionStatus status =
          checkVoxelCount(header.voxel_count, limits.max_voxels, what);
      !status.ok())
    return status;
  if (header.is_i_frame && header.content.has_scan)
    if (CompressionStatus status = checkPixelCount(header.scan, limits); !status.ok())
      return status;
  if (header.point_count > limits.max_points)
    return {CompressionCode::LimitExceeded,
            "frame header: " + std::to_string(header.point_count) +
                " points exceed the limit of " + std::to_string(limits.max_points)};
  if (header.coarse_voxel_count > header.voxel_count ||
      (header.coarse_voxel_count == 0 && header.content.refinement_levels > 0 &&
       header.voxel_count > 0))
    return corruptFrame("invalid number of coarse voxels");
  if (header.content.has_point_counts &&
      (header.point_count < header.voxel_count ||
       (header.voxel_count == 0 && header.point_count > 0)))
    return corruptFrame("invalid number of points");
  if (header.is_of_changes && header.voxel_count == 0)
    return corruptFrame("a frame of changes without voxels");
  if (!header.is_i_frame && header.stamp == std::numeric_limits<std::int64_t>::min())
    return corruptFrame("invalid difference of stamps");
  const std::size_t model_size = header.has_depth_model ? depth_model_size : 0;
  if (header.payload_size < model_size)
    return corruptFrame("payload smaller than its depth model");
  if (header.supplement_size > header.payload_size - model_size)
    return corruptFrame("payload smaller than its supplement");
  if (header.padding_size > header.payload_size - model_size - header.supplement_size)
    return corruptFrame("payload smaller than its padding");
  return {};
}

} // namespace

bool
beginsFrameOfChanges(const std::uint8_t* bytes, std::size_t size)
{
  return size > checksum_end &&
         std::equal(version1_magic, version1_magic + version1_magic_size, bytes) &&
         (bytes[checksum_end] & (i_frame_flag | changes_flag)) == changes_flag;
}

std::uint64_t
fieldValuesOf(const Version1Header& header, const std::vector<FieldDescription>& fields)
{
  std::uint64_t values = 0;
  for (const FieldDescription& field : fields)
    values += field.count;
  // A decoded cloud has values in all pixels.
  if (header.content.has_scan && header.scan.order == scan::PointOrder::Organised)
    return values * header.scan.pixelCount();
  return values *
         (header.content.has_point_counts ? header.point_count : header.voxel_count);
}

CompressionStatus
checkPixelCount(const scan::ScanLayout& layout, const FrameLimits& limits)
{
  if (layout.pixelCount() <= limits.max_points)
    return {};
  return {CompressionCode::LimitExceeded,
          "frame header: a scan of " + std::to_string(layout.pixelCount()) +
              " pixels exceeds the limit of " + std::to_string(limits.max_points) +
              " points"};
}

FrameLimits
limitsOf(const Version1Header& header,
         const DecoderLimits& limits,
         std::uint64_t bytes_before)
{
  return frameLimits(limits,
                     header.payload_size + (header.is_i_frame ? 0 : bytes_before));
}

void
writeDepthModel(const DepthModel& model, std::vector<std::uint8_t>& payload)
{
  ByteWriter writer(payload);
  writer.u8(model.exponent);
  writer.u32(model.full_symbol);
  writer.u64(static_cast<std::uint64_t>(model.origin));
  for (const std::int32_t step : model.step)
    writer.i32(step);
}

bool
readDepthModel(const std::uint8_t* bytes, DepthModel& model)
{
  MemoryBuffer buffer(bytes, depth_model_size);
  ByteSource source(buffer, depth_model_size);
  model.exponent = source.u8();
  model.full_symbol = source.u32();
  model.origin = static_cast<std::int64_t>(source.u64());
  for (std::int32_t& step : model.step)
    step = source.i32();
  return isConsistent(model);
}

std::uint32_t
writeVersion1Frame(const Version1Header& header,
                   const std::vector<std::uint8_t>& payload,
                   std::uint32_t reference_checksum,
                   std::vector<std::uint8_t>& bytes)
{
  const std::size_t begin = bytes.size();
  reserveAhead(bytes,
               begin + usual_header_bytes + header.frame_id.size() + payload.size());
  ByteWriter writer(bytes);
  writer.raw(version1_magic, version1_magic_size);
  writer.u8(version);
  writer.u32(0); // replaced by the checksum below
  writeFields(header, writer);
  writer.raw(payload.data(), payload.size());

  const std::size_t checked_begin = begin + checksum_end;
  const std::uint32_t checksum = chainedChecksum(
      reference_checksum, bytes.data() + checked_begin, bytes.size() - checked_begin);
  for (std::size_t i = 0; i < 4; ++i)
    bytes[checked_begin - 4 + i] = static_cast<std::uint8_t>(checksum >> (8 * i));
  return checksum;
}

std::uint32_t
version1ChecksumOf(const std::uint8_t* bytes)
{
  constexpr std::size_t begin = version1_magic_size + 1;
  MemoryBuffer buffer(bytes + begin, checksum_end - begin);
  return ByteSource(buffer, checksum_end - begin).u32();
}

bool
holdsVersion1Checksum(const std::uint8_t* bytes,
                      std::size_t size,
                      std::uint32_t reference_checksum)
{
  return size >= checksum_end &&
         chainedChecksum(reference_checksum,
                         bytes + checksum_end,
                         size - checksum_end) == version1ChecksumOf(bytes);
}

CompressionStatus
readVersion1Header(ByteSource& source,
                   const DecoderLimits& limits,
                   Version1Header& header,
                   std::uint32_t& checksum,
                   std::vector<std::uint8_t>& checked_bytes,
                   std::uint64_t bytes_before)
{
  clear(header);
  const std::uint8_t stream_version = source.u8();
  if (source.failure() == ByteSource::Failure::None && stream_version != version)
    return {CompressionCode::UnsupportedVersion,
            "frame header: unsupported stream version " +
                std::to_string(stream_version)};
  checksum = source.u32();
  checked_bytes.clear();
  source.recordTo(&checked_bytes);
  const std::uint8_t flags = source.u8();
  const unsigned int effort = flags >> effort_shift & effort_mask;
  header.is_i_frame = (flags & i_frame_flag) != 0;
  header.is_of_changes = !header.is_i_frame && (flags & changes_flag) != 0;
  header.has_depth_model = (flags & depth_model_flag) != 0;
  if (effort > static_cast<unsigned int>(Effort::Small) ||
      (header.is_of_changes && (header.has_depth_model || (flags & content_flag) != 0)))
    return corruptFrame("unknown flags");
  header.effort = static_cast<Effort>(effort);
  CompressionStatus status = readFields(source, flags, header);
  if (status.ok() && source.failure() == ByteSource::Failure::None)
    status = checkFields(header, limits, bytes_before);
  source.recordTo(nullptr);
  return source.failure() != ByteSource::Failure::None
             ? failedRead(source, "a frame header")
             : status;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
