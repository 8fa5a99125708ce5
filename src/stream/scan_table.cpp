// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/scan_table.h"

#include "codec/frame_failures.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

using scan::PointOrder;
using scan::RayPose;
using scan::RayRow;
using scan::RayShape;
using scan::ScanLayout;
using scan::ScanRays;

// Of the byte after width and height; the order is in the lowest two bits, the shape of
// the rays in the next two.
constexpr unsigned int order_mask = 3;
constexpr unsigned int shape_shift = 2;
constexpr unsigned int shape_mask = 3;
constexpr unsigned int lattice_flag = 16;
constexpr unsigned int shift_flag = 32;
constexpr unsigned int half_depths_flag = 64;
constexpr unsigned int most_flags = 127;

/** \brief The numbers of a row, in the order of the table. */
constexpr std::array<std::int32_t RayRow::*, 7> row_numbers = {&RayRow::cosine,
                                                               &RayRow::sine,
                                                               &RayRow::run,
                                                               &RayRow::rise,
                                                               &RayRow::along,
                                                               &RayRow::across,
                                                               &RayRow::up};

/** \brief A number, or where it has too many bits one that no rays have. */
std::int32_t
numberOrNone(std::int64_t number)
{
  using Limits = std::numeric_limits<std::int32_t>;
  return number >= Limits::min() && number <= Limits::max()
             ? static_cast<std::int32_t>(number)
             : Limits::min();
}

void
writePose(const RayPose& pose, ByteWriter& writer)
{
  for (const std::int64_t position : pose.origin)
    writer.signedVarint(position);
  for (const auto& vector : pose.vectors)
    for (const std::int64_t element : vector)
      writer.signedVarint(element);
}

void
readPose(ByteSource& source, RayPose& pose)
{
  for (std::int64_t& position : pose.origin)
    position = source.signedVarint();
  for (auto& vector : pose.vectors)
    for (std::int64_t& element : vector)
      element = source.signedVarint();
}

bool
isMotion(const RayPose& motion)
{
  return motion != RayPose();
}

/** \brief Writes a motion: a byte of 0 if there is none, else 1 and its numbers. */
void
writeMotion(const RayPose& motion, ByteWriter& writer)
{
  writer.u8(isMotion(motion) ? 1 : 0);
  if (isMotion(motion))
    writePose(motion, writer);
}

/** \brief Reads a motion; one that no layout has where the first byte is none. */
void
readMotion(ByteSource& source, RayPose& motion)
{
  const std::uint8_t has_motion = source.u8();
  motion = RayPose();
  if (has_motion == 1)
    readPose(source, motion);
  if (has_motion > 1)
    motion.origin[0] = std::numeric_limits<std::int64_t>::max();
}

void
writeSpinningRays(const ScanRays& rays, ByteWriter& writer)
{
  writer.u8(static_cast<std::uint8_t>(rays.turns.size()));
  for (const auto& turn : rays.turns)
    for (const std::int32_t element : turn)
      writer.signedVarint(element);
  RayRow last;
  for (const RayRow& row : rays.rows) {
    for (const auto number : row_numbers)
      writer.signedVarint(std::int64_t{row.*number} - last.*number);
    last = row;
  }
}

void
readSpinningRays(ByteSource& source, ScanLayout& layout)
{
  ScanRays& rays = layout.rays;
  rays.turns.resize(source.u8());
  for (auto& turn : rays.turns)
    for (std::int32_t& element : turn)
      element = numberOrNone(source.signedVarint());
  RayRow row;
  for (std::uint32_t i = 0;
       i < layout.height && source.failure() == ByteSource::Failure::None;
       ++i) {
    for (const auto number : row_numbers) {
      const std::int64_t difference = source.signedVarint();
      constexpr std::int64_t most = std::int64_t{1} << 32;
      const bool is_near = difference >= -most && difference <= most;
      row.*number =
          is_near ? numberOrNone(row.*number + difference) : numberOrNone(most);
    }
    rays.rows.push_back(row);
  }
}

/** \brief Reads a number of each row, as long as there are bytes.
 * \return false if one is not below its end
 */
bool
readRows(ByteSource& source,
         std::uint32_t rows,
         std::uint32_t end,
         std::vector<std::uint16_t>& numbers)
{
  for (std::uint32_t row = 0;
       row < rows && source.failure() == ByteSource::Failure::None;
       ++row) {
    const std::uint64_t number = source.varint();
    if (number >= std::min(end, scan::most_side))
      return false;
    numbers.push_back(static_cast<std::uint16_t>(number));
  }
  return true;
}

} // namespace

void
writeScanTable(const ScanLayout& layout, ByteWriter& writer)
{
  writer.varint(layout.width);
  writer.varint(layout.height);
  const auto shape = static_cast<unsigned int>(layout.rays.shape);
  writer.u8(static_cast<std::uint8_t>(
      static_cast<unsigned int>(layout.order) | shape << shape_shift |
      (layout.is_on_lattice ? lattice_flag : 0u) |
      (layout.rays.has_half_depths ? half_depths_flag : 0u) |
      (layout.row_shifts.empty() ? 0u : shift_flag)));
  for (const std::uint16_t row : layout.firing_order)
    writer.varint(row);
  for (const std::uint16_t shift : layout.row_shifts)
    writer.varint(shift);
  writePose(layout.rays.pose, writer);
  if (layout.rays.shape != RayShape::Spinning)
    return;
  writeMotion(layout.rays.motion, writer);
  writeSpinningRays(layout.rays, writer);
}

CompressionStatus
readScanTable(ByteSource& source, ScanLayout& layout)
{
  layout = ScanLayout();
  const std::uint64_t width = source.varint();
  const std::uint64_t height = source.varint();
  const std::uint8_t flags = source.u8();
  if (source.failure() != ByteSource::Failure::None)
    return {};
  if (width > scan::most_pixels || height > scan::most_pixels ||
      width * height > scan::most_pixels || flags > most_flags)
    return corruptFrame("invalid scan");
  layout.width = static_cast<std::uint32_t>(width);
  layout.height = static_cast<std::uint32_t>(height);
  layout.order = static_cast<PointOrder>(flags & order_mask);
  layout.is_on_lattice = (flags & lattice_flag) != 0;
  if (layout.order == PointOrder::ColumnByColumn &&
      !readRows(source, layout.height, layout.height, layout.firing_order))
    return corruptFrame("invalid scan");
  if ((flags & shift_flag) != 0 &&
      !readRows(source, layout.height, layout.width, layout.row_shifts))
    return corruptFrame("invalid scan");
  layout.rays.shape = static_cast<RayShape>(flags >> shape_shift & shape_mask);
  layout.rays.has_half_depths = (flags & half_depths_flag) != 0;
  readPose(source, layout.rays.pose);
  if (layout.rays.shape == RayShape::Spinning) {
    readMotion(source, layout.rays.motion);
    readSpinningRays(source, layout);
  }
  if (source.failure() == ByteSource::Failure::None && !isConsistent(layout))
    return corruptFrame("invalid scan");
  return {};
}

void
writeScanPlacement(const ScanPlacement& placement, ByteWriter& writer)
{
  writer.varint(placement.width);
  writer.varint(placement.height);
  writePose(placement.pose, writer);
  writeMotion(placement.motion, writer);
}

void
readScanPlacement(ByteSource& source, ScanPlacement& placement)
{
  for (std::uint32_t* const side : {&placement.width, &placement.height}) {
    const std::uint64_t length = source.varint();
    // 0 is a side of no layout.
    *side = length <= scan::most_pixels ? static_cast<std::uint32_t>(length) : 0;
  }
  readPose(source, placement.pose);
  readMotion(source, placement.motion);
}

} // namespace pcl_ext::PCL_EXT_ABI::io
