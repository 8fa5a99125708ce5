// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Changes of frames for a mutator: fields of headers, depth models, payloads,
 * symbols of the published layout.
 */
#pragma once

#include "bytes/byte_source.h"
#include "bytes/byte_writer.h"
#include "checked_decoding.h"
#include "codec/published/entropy_coder.h"
#include "frame_row.h"
#include "support/voxel_streams.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

// Of the fuzzer: changes bytes as it does for targets without a mutator of their own.
extern "C" std::size_t
LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace pcl_ext::fuzz {

using io::test::Parts;

/** \brief Random numbers that cost nothing to begin with (splitmix64). */
class Random {
public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t
  next()
  {
    state_ += 0x9e3779b97f4a7c15;
    std::uint64_t mixed = state_;
    mixed = (mixed ^ mixed >> 30) * 0xbf58476d1ce4e5b9;
    mixed = (mixed ^ mixed >> 27) * 0x94d049bb133111eb;
    return mixed ^ mixed >> 31;
  }

  std::size_t
  below(std::size_t end)
  {
    return static_cast<std::size_t>(next() % end);
  }

  bool
  oneOf(std::size_t count)
  {
    return below(count) == 0;
  }

private:
  std::uint64_t state_;
};

/** \brief Any number: small ones, such next to a power of two, and all others. */
inline std::uint64_t
anyNumber(Random& random)
{
  switch (random.below(4)) {
  case 0:
    return random.below(4);
  case 1:
    return (std::uint64_t{1} << random.below(64)) + random.below(3) - 1;
  case 2:
    return random.below(2000);
  default:
    return random.next();
  }
}

template <typename NumberT>
void
change(NumberT& number, Random& random)
{
  number = static_cast<NumberT>(random.oneOf(2) ? static_cast<std::uint64_t>(number) +
                                                      random.below(5) - 2
                                                : anyNumber(random));
}

template <typename NumberT, typename BitsT>
void
changeBits(NumberT& number, Random& random)
{
  static_assert(sizeof(NumberT) == sizeof(BitsT), "bits of the number");
  BitsT bits;
  std::memcpy(&bits, &number, sizeof(bits));
  if (random.oneOf(4))
    bits = static_cast<BitsT>(anyNumber(random));
  else
    bits = static_cast<BitsT>(bits ^ BitsT{1} << random.below(8 * sizeof(bits)));
  std::memcpy(&number, &bits, sizeof(bits));
}

inline void
changeBytes(Bytes& bytes, std::size_t most)
{
  const std::size_t size = bytes.size();
  bytes.resize(std::max(size + 32, std::size_t{64}));
  bytes.resize(LLVMFuzzerMutate(bytes.data(), size, std::min(bytes.size(), most)));
}

inline void
changeDepthModel(Bytes& payload, Random& random)
{
  io::DepthModel model;
  if (payload.size() < io::depth_model_size)
    return;
  io::readDepthModel(payload.data(), model);
  switch (random.below(4)) {
  case 0:
    change(model.exponent, random);
    break;
  case 1:
    change(model.full_symbol, random);
    break;
  case 2:
    change(model.origin, random);
    break;
  default:
    change(model.step[random.below(3)], random);
  }
  Bytes written;
  io::writeDepthModel(model, written);
  std::copy(written.begin(), written.end(), payload.begin());
}

inline void
changeScale(io::IntensityScale& scale, Random& random)
{
  switch (random.below(4)) {
  case 0:
    changeBits<float, std::uint32_t>(scale.offset, random);
    break;
  case 1:
    changeBits<float, std::uint32_t>(scale.step, random);
    break;
  case 2:
    scale.bits = static_cast<unsigned int>(random.below(18));
    break;
  default:
    scale.companded_range = static_cast<std::uint32_t>(random.below(1 << 16));
  }
}

inline void
changePose(io::scan::RayPose& pose, Random& random)
{
  if (random.oneOf(2))
    change(pose.origin[random.below(3)], random);
  else
    change(pose.vectors[random.below(3)][random.below(3)], random);
}

/** \brief Changes the size of a scan, the order of its points or its rays. */
inline void
changeScan(io::scan::ScanLayout& scan, Random& random)
{
  io::scan::ScanRays& rays = scan.rays;
  switch (random.below(8)) {
  case 0:
    change(random.oneOf(2) ? scan.width : scan.height, random);
    break;
  case 1:
    scan.order = static_cast<io::scan::PointOrder>(random.below(3));
    break;
  case 2:
    scan.is_on_lattice = !scan.is_on_lattice;
    break;
  case 3:
    if (!scan.firing_order.empty())
      change(scan.firing_order[random.below(scan.firing_order.size())], random);
    break;
  case 4:
    if (!rays.turns.empty())
      change(rays.turns[random.below(rays.turns.size())][random.below(2)], random);
    break;
  case 5:
    if (!rays.rows.empty()) {
      io::scan::RayRow& row = rays.rows[random.below(rays.rows.size())];
      change(random.oneOf(2) ? row.run : row.across, random);
    }
    break;
  case 6:
    changePose(rays.motion, random);
    break;
  default:
    changePose(rays.pose, random);
  }
}

/** \brief Changes where messages have their fields, or makes a layout. */
inline void
changeLayout(std::shared_ptr<const io::MessageLayout>& layout, Random& random)
{
  io::MessageLayout changed = layout ? *layout : io::MessageLayout();
  io::PlacedField field;
  field.name = "x";
  switch (random.below(4)) {
  case 0:
    change(changed.point_step, random);
    break;
  case 1:
    change(changed.row_padding, random);
    break;
  case 2:
    changed.fields.resize(random.below(random.oneOf(8) ? 2000 : 4), field);
    break;
  default:
    if (!changed.fields.empty())
      change(random.oneOf(2) ? changed.fields.front().offset
                             : changed.fields.front().count,
             random);
  }
  layout = std::make_shared<io::MessageLayout>(std::move(changed));
}

inline void
changeContent(io::Version1Header& header, Random& random)
{
  switch (random.below(10)) {
  case 0:
    header.content.refinement_levels = static_cast<unsigned int>(random.below(22));
    break;
  case 1:
    header.content.colour_bits = static_cast<unsigned int>(random.below(10));
    break;
  case 2:
    header.content.has_point_counts = !header.content.has_point_counts;
    break;
  case 3:
    change(header.coarse_voxel_count, random);
    break;
  case 4:
    change(header.point_count, random);
    break;
  case 5:
    changeBits<double, std::uint64_t>(header.grid.origin[random.below(3)], random);
    break;
  case 6:
    change(header.padding_size, random);
    break;
  case 7:
    header.content.has_scan = !header.content.has_scan;
    break;
  case 8:
    changeLayout(header.layout, random);
    break;
  default:
    change(header.supplement_size, random);
  }
}

inline void
changeHeader(Parts& parts, Random& random)
{
  io::Version1Header& header = parts.header;
  switch (random.below(13)) {
  case 0:
    header.is_i_frame = !header.is_i_frame;
    break;
  case 1:
    header.has_depth_model = !header.has_depth_model;
    if (header.has_depth_model)
      parts.payload.insert(parts.payload.begin(), io::depth_model_size, 1);
    break;
  case 2:
    header.effort = static_cast<io::Effort>(random.below(3));
    break;
  case 3:
    change(header.frame_number, random);
    break;
  case 4:
    changeBits<double, std::uint64_t>(header.grid.resolution, random);
    break;
  case 5:
    change(header.grid.first_index[random.below(3)], random);
    break;
  case 6:
    header.grid.depth = static_cast<unsigned int>(random.below(24));
    break;
  case 7:
    changeScale(header.intensity_scale, random);
    break;
  case 8:
    if (random.oneOf(3))
      header.stamp.reset();
    else
      header.stamp = static_cast<std::int64_t>(anyNumber(random));
    break;
  case 9:
    header.has_frame_id = !header.has_frame_id;
    header.frame_id.assign(random.below(random.oneOf(8) ? 1100 : 30), 'f');
    break;
  case 10:
    changeContent(header, random);
    break;
  case 11:
    header.is_of_changes = !header.is_of_changes;
    break;
  default:
    change(header.voxel_count, random);
  }
}

inline void
changeVersion1(RowFrame& frame, Random& random)
{
  std::optional<Parts> parts = frame.parts();
  if (!parts || random.oneOf(16)) {
    changeBytes(frame.bytes, smallLimits().max_frame_bytes);
    return;
  }
  const std::size_t kind = random.below(8);
  if (kind < 2)
    changeHeader(*parts, random);
  else if (kind == 2 && parts->header.placement)
    changePose(parts->header.placement->pose, random);
  else if (kind == 2 && parts->header.content.has_scan)
    changeScan(parts->header.scan, random);
  else if (kind == 2)
    changeHeader(*parts, random);
  else if (kind == 3 && parts->header.has_depth_model)
    changeDepthModel(parts->payload, random);
  else
    changeBytes(parts->payload, smallLimits().max_frame_bytes);
  // Sizes are wrong now and then.
  if (random.oneOf(16))
    change(parts->header.payload_size, random);
  else
    parts->header.payload_size = parts->payload.size();
  frame.bytes = putTogether(*parts);
}

/** \brief Changes symbols of the published layout; its redundancy, which stands in for
 * a checksum, is right again. */
inline void
changePublished(RowFrame& frame, Random& random)
{
  constexpr std::size_t header_size = io::published::magic_size + 4 + 1;
  constexpr std::size_t grid_size = 8 + 7 * 8;
  const std::size_t begin =
      frame.bytes.size() > header_size && frame.bytes[header_size - 1] != 0
          ? header_size + grid_size
          : header_size;
  Bytes rows[2]; // occupancy bytes and intensities
  bool is_whole = frame.bytes.size() >= begin;
  if (is_whole) {
    io::MemoryBuffer buffer(frame.bytes.data() + begin, frame.bytes.size() - begin);
    io::ByteSource source(buffer, frame.bytes.size());
    for (Bytes& row : rows) {
      const std::uint64_t count = source.u64();
      is_whole = is_whole && count <= smallLimits().max_frame_bytes &&
                 io::published::decodeStaticRange(
                     source, static_cast<std::size_t>(count), row);
    }
  }
  if (!is_whole || random.oneOf(8)) {
    changeBytes(frame.bytes, smallLimits().max_frame_bytes);
    return;
  }
  std::uint64_t counts[2];
  Bytes& changed = rows[random.below(2)];
  changeBytes(changed, smallLimits().max_voxels);
  for (std::size_t i = 0; i < 2; ++i)
    counts[i] = rows[i].size();
  // Mostly as many intensities as there were or as there are said to be.
  if (random.oneOf(16))
    change(counts[random.below(2)], random);
  frame.bytes.resize(begin);
  if (begin > header_size && !random.oneOf(8))
    for (std::size_t i = 0; i < 8; ++i)
      frame.bytes[header_size + i] = static_cast<std::uint8_t>(counts[1] >> 8 * i);
  io::ByteWriter writer(frame.bytes);
  for (std::size_t i = 0; i < 2; ++i) {
    writer.u64(counts[i]);
    io::published::encodeStaticRange(rows[i], frame.bytes);
  }
}

inline void
changeFrame(RowFrame& frame, Random& random)
{
  if (frame.isVersion1())
    changeVersion1(frame, random);
  else if (frame.isPublished())
    changePublished(frame, random);
  else
    changeBytes(frame.bytes, smallLimits().max_frame_bytes);
}

/** \brief An I-frame of any grid and scale, with any bytes as payload. */
inline Bytes
forgedFrame(Random& random)
{
  Parts parts;
  io::Version1Header& header = parts.header;
  header.effort = static_cast<io::Effort>(random.below(3));
  header.frame_number = static_cast<std::uint32_t>(random.below(5));
  header.grid.resolution = 0.04;
  header.grid.depth = static_cast<unsigned int>(1 + random.below(io::max_grid_depth));
  if (header.grid.depth == io::max_grid_depth)
    header.grid.first_index.fill(-(1 << 20));
  header.intensity_scale.bits = static_cast<unsigned int>(1 + random.below(16));
  if (random.oneOf(4))
    header.intensity_scale.companded_range = 65535;
  header.voxel_count = random.below(random.oneOf(4) ? 1025 : 20);
  parts.payload.resize(random.below(random.oneOf(4) ? 400 : 40));
  for (std::uint8_t& byte : parts.payload)
    byte = static_cast<std::uint8_t>(random.next());
  header.has_depth_model = random.oneOf(4);
  if (header.has_depth_model) {
    Bytes model;
    io::writeDepthModel(
        io::test::roomDepthModel(header.grid.depth, header.intensity_scale.bits),
        model);
    parts.payload.insert(parts.payload.begin(), model.begin(), model.end());
  }
  return io::test::putTogetherSized(parts);
}

} // namespace pcl_ext::fuzz
