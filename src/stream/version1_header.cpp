#include "stream/version1_header.h"

#include "bytes/byte_source.h"
#include "bytes/byte_writer.h"
#include "bytes/checksum.h"
#include "bytes/reserve_ahead.h"
#include "codec/frame_failures.h"
#include "voxels/grid_fit.h"

#include <cmath>
#include <limits>
#include <utility>

namespace pcl_ext {
namespace io {

namespace {

constexpr std::uint8_t version = 1;
constexpr std::size_t checksum_end = version1_magic_size + 1 + 4;
// Without the frame_id.
constexpr std::size_t most_header_bytes = 96;

enum Flag : std::uint8_t {
  i_frame_flag = 1,
  depth_model_flag = 2,
  stamp_flag = 4,
  frame_id_flag = 8
};

// Set in the number of bits of a companded scale, whose range follows.
constexpr std::uint8_t companded_flag = 0x80;

// The effort is in the bits above the flags.
constexpr unsigned int effort_shift = 4;

std::uint8_t
flagsOf(const Version1Header& header)
{
  return static_cast<std::uint8_t>((header.is_i_frame ? i_frame_flag : 0) |
                                   (header.has_depth_model ? depth_model_flag : 0) |
                                   (header.stamp ? stamp_flag : 0) |
                                   (header.has_frame_id ? frame_id_flag : 0) |
                                   static_cast<int>(header.effort) << effort_shift);
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
  if (header.is_i_frame) {
    writer.f64(header.grid.resolution);
    for (const std::int32_t index : header.grid.first_index)
      writer.i32(index);
    writer.u8(static_cast<std::uint8_t>(header.grid.depth));
    writeIntensityScale(header.intensity_scale, writer);
  }
  if (header.stamp && header.is_i_frame)
    writer.u64(static_cast<std::uint64_t>(*header.stamp));
  else if (header.stamp)
    writer.signedVarint(*header.stamp);
  if (header.has_frame_id) {
    writer.varint(header.frame_id.size());
    writer.raw(header.frame_id.data(), header.frame_id.size());
  }
  writer.varint(header.voxel_count);
  writer.varint(header.payload_size);
}

CompressionStatus
readGrid(ByteSource& source, VoxelGrid& grid)
{
  grid = VoxelGrid();
  grid.resolution = source.f64();
  for (std::int32_t& index : grid.first_index)
    index = source.i32();
  grid.depth = source.u8();
  if (source.failure() != ByteSource::Failure::None)
    return {};
  if (CompressionStatus status = checkResolution(grid.resolution); !status.ok())
    return status;
  if (grid.depth < 1 || grid.depth > max_grid_depth)
    return corruptFrame("grid depth outside 1 to 21");
  if (leavesLattice(grid))
    return corruptFrame("grid outside the lattice");
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
  for (std::uint64_t i = 0; i < size && source.failure() == ByteSource::Failure::None;
       ++i)
    frame_id.push_back(static_cast<char>(source.u8()));
  return {};
}

CompressionStatus
readFields(ByteSource& source, std::uint8_t flags, Version1Header& header)
{
  header.frame_number = source.u32();
  CompressionStatus status;
  if (header.is_i_frame)
    status = readGrid(source, header.grid);
  if (status.ok() && header.is_i_frame)
    status = readIntensityScale(source, header.intensity_scale);
  if (status.ok() && (flags & stamp_flag) != 0)
    header.stamp = header.is_i_frame ? static_cast<std::int64_t>(source.u64())
                                     : source.signedVarint();
  header.has_frame_id = (flags & frame_id_flag) != 0;
  if (status.ok() && header.has_frame_id)
    status = readFrameId(source, header.frame_id);
  header.voxel_count = source.varint();
  header.payload_size = source.varint();
  return status;
}

/** \brief Checks the fields that do not depend on the payload. */
CompressionStatus
checkFields(const Version1Header& header, const DecoderLimits& limits)
{
  if (CompressionStatus status = checkVoxelCount(header.voxel_count, limits);
      !status.ok())
    return status;
  if (header.payload_size > limits.max_frame_bytes)
    return {CompressionCode::LimitExceeded,
            "frame header: payload exceeds the limit of " +
                std::to_string(limits.max_frame_bytes) + " bytes"};
  if (!header.is_i_frame && header.stamp == std::numeric_limits<std::int64_t>::min())
    return corruptFrame("invalid difference of stamps");
  if (header.payload_size < (header.has_depth_model ? depth_model_size : 0))
    return corruptFrame("payload smaller than its depth model");
  return {};
}

} // namespace

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
               begin + most_header_bytes + header.frame_id.size() + payload.size());
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

CompressionStatus
readVersion1Header(ByteSource& source,
                   const DecoderLimits& limits,
                   Version1Header& header,
                   std::uint32_t& checksum,
                   std::vector<std::uint8_t>& checked_bytes)
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
  if (flags >> effort_shift > static_cast<int>(Effort::Small))
    return corruptFrame("unknown flags");
  header.effort = static_cast<Effort>(flags >> effort_shift);
  header.is_i_frame = (flags & i_frame_flag) != 0;
  header.has_depth_model = (flags & depth_model_flag) != 0;
  CompressionStatus status = readFields(source, flags, header);
  if (status.ok() && source.failure() == ByteSource::Failure::None)
    status = checkFields(header, limits);
  source.recordTo(nullptr);
  return source.failure() != ByteSource::Failure::None
             ? failedRead(source, "a frame header")
             : status;
}

} // namespace io
} // namespace pcl_ext
