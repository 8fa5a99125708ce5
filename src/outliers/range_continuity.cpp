// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outliers/range_continuity.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace pcl_ext::PCL_EXT_ABI {

namespace {

constexpr double offset = 2.5;
constexpr double row_floor = 0.3;
constexpr float depth_weight = 1.5f;
constexpr float last_weight = 2.5f;
constexpr float last_offset = -1.5f;
/** \brief From here on the last image changes no decision. */
constexpr float sure = 6.0f;

} // namespace

RangeContinuity::RangeContinuity()
{
  for (std::size_t i = 0; i < table_size; ++i) {
    const double mantissa = 1.0 + (static_cast<double>(i % 1024) + 0.5) / 1024.0;
    codes_[i] = static_cast<Code>(std::lround(
        codes_of_one * std::log(std::ldexp(mantissa, static_cast<int>(i / 1024)))));
  }
  for (std::size_t support = 0; support < row_terms_.size(); ++support)
    row_terms_[support] = static_cast<float>(
        offset + 2.0 * std::log(row_floor + static_cast<double>(support) / row_width));
}

void
RangeContinuity::score(const std::vector<float>& ranges,
                       std::uint32_t width,
                       std::uint32_t height,
                       bool uses_last,
                       std::vector<float>& log_odds)
{
  if (width != width_ || height != height_)
    resize(width, height);
  for (std::uint32_t row = 0; row < height; ++row)
    encode(ranges.data() + std::size_t{row} * width, row);
  log_odds.resize(ranges.size());
  const bool judges_by_last = uses_last && has_last_ && isStill();
  for (std::uint32_t row = 0; row < height; ++row)
    for (std::uint32_t column = 0; column < width; column += chunk)
      judge(row, column, judges_by_last, log_odds.data());
  image_.swap(last_image_);
  has_last_ = true;
}

void
RangeContinuity::resize(std::uint32_t width, std::uint32_t height)
{
  // Unless both images get their memory there are none.
  reset();
  stride_ = std::size_t{(width + chunk - 1) / chunk} * chunk + 2 * margin;
  image_.assign(stride_ * height, no_return);
  last_image_ = image_;
  width_ = width;
  height_ = height;
}

/** \brief Sets the codes of a row, and those of its margins. */
void
RangeContinuity::encode(const float* ranges, std::uint32_t row)
{
  Code* const codes = image_.data() + row * stride_ + margin;
  for (std::uint32_t column = 0; column < width_; ++column) {
    const float ratio = 1.0f + ranges[column] / near_range;
    std::uint32_t bits;
    std::memcpy(&bits, &ratio, sizeof(bits));
    // Exponent and 10 bits of the mantissa.
    const std::size_t index = (bits - 0x3f800000u) >> 13;
    codes[column] =
        ranges[column] > 0.0f ? codes_[std::min(index, table_size - 1)] : no_return;
  }
  for (std::uint32_t i = 0; i < margin; ++i) {
    codes[width_ + i] = codes[i];
    codes[static_cast<std::ptrdiff_t>(i) - margin] = codes[width_ - margin + i];
  }
}

// Loops of fixed length without aliases, which compilers turn into vector code.

/** \brief Adds max(0, width - |difference|). */
void
RangeContinuity::addSupport(const Code* centre, const Code* other, Code* sum)
{
  for (std::uint32_t i = 0; i < chunk; ++i) {
    const auto step = static_cast<Code>(other[i] - centre[i]);
    const Code distance = std::max(step, static_cast<Code>(-step));
    const auto support = static_cast<Code>(row_width - distance);
    sum[i] = static_cast<Code>(sum[i] + std::max<Code>(support, 0));
  }
}

/** \brief The same for the best of three columns of another row. */
void
RangeContinuity::addBestSupport(const Code* centre, const Code* other, Code* sum)
{
  for (std::uint32_t i = 0; i < chunk; ++i) {
    const auto left =
        static_cast<Code>(other[static_cast<std::ptrdiff_t>(i) - 1] - centre[i]);
    const auto middle = static_cast<Code>(other[i] - centre[i]);
    const auto right = static_cast<Code>(other[i + 1] - centre[i]);
    const Code from_left = std::max(left, static_cast<Code>(-left));
    const Code from_middle = std::max(middle, static_cast<Code>(-middle));
    const Code from_right = std::max(right, static_cast<Code>(-right));
    const Code distance = std::min(from_middle, std::min(from_left, from_right));
    const auto support = static_cast<Code>(column_width - distance);
    sum[i] = static_cast<Code>(sum[i] + std::max<Code>(support, 0));
  }
}

/** \brief Adds how much farther another ray sees. */
void
RangeContinuity::addDepth(const Code* centre, const Code* other, Code* sum)
{
  for (std::uint32_t i = 0; i < chunk; ++i) {
    const auto step = static_cast<Code>(other[i] - centre[i]);
    const Code bounded =
        std::max<Code>(std::min<Code>(step, farthest), static_cast<Code>(-farthest));
    sum[i] = static_cast<Code>(sum[i] + (other[i] < 0 ? beyond_sight : bounded));
  }
}

/** \brief Judges the pixels of a chunk of a row. */
void
RangeContinuity::judge(std::uint32_t row,
                       std::uint32_t column,
                       bool uses_last,
                       float* log_odds) const
{
  alignas(16) Code in_row[chunk] = {};
  alignas(16) Code in_columns[chunk] = {};
  alignas(16) Code depth[chunk] = {};
  const Code* const centre = at(image_, row) + column;
  for (int side = 1; side <= 4; ++side) {
    addSupport(centre, centre - side, in_row);
    addSupport(centre, centre + side, in_row);
  }
  int neighbours = 4;
  for (const int side : {-2, -1, 1, 2})
    addDepth(centre, centre + side, depth);
  for (const int step : {-2, -1, 1, 2}) {
    const std::int64_t other_row = std::int64_t{row} + step;
    if (other_row < 0 || other_row >= height_)
      continue;
    const Code* const other =
        at(image_, static_cast<std::uint32_t>(other_row)) + column;
    addBestSupport(centre, other, in_columns);
    if (std::abs(step) == 1) {
      for (int side = -2; side <= 2; ++side)
        addDepth(centre, other + side, depth);
      neighbours += 5;
    }
  }
  const float scale =
      depth_weight / static_cast<float>(farthest * neighbours * column_width);
  float* const results = log_odds + std::size_t{row} * width_ + column;
  const std::uint32_t end = std::min(chunk, width_ - column);
  for (std::uint32_t i = 0; i < end; ++i) {
    if (centre[i] < 0) {
      results[i] = 0.0f;
      continue;
    }
    const int missing = column_neighbours * column_width - in_columns[i];
    float result = row_terms_[static_cast<std::size_t>(in_row[i])] +
                   static_cast<float>(in_columns[i]) * (1.0f / column_width) -
                   scale * static_cast<float>(depth[i] * missing);
    if (uses_last)
      result += (result < sure ? last_weight * seenBefore(row, column + i, centre[i])
                               : last_weight) +
                last_offset;
    results[i] = result;
  }
}

/** \brief 0..1: how well the best of 3 x 9 pixels of the last image agrees. */
float
RangeContinuity::seenBefore(std::uint32_t row, std::uint32_t column, Code code) const
{
  int best = column_width;
  const std::uint32_t last_row = std::min(row + 1, height_ - 1);
  for (std::uint32_t other = row > 0 ? row - 1 : 0; other <= last_row; ++other) {
    const Code* const codes = at(last_image_, other) + column;
    for (int side = -static_cast<int>(margin); side <= static_cast<int>(margin); ++side)
      best = std::min(best, std::abs(codes[side] - code));
  }
  return 1.0f - static_cast<float>(best) * (1.0f / column_width);
}

/** \brief Whether most of what goes on to both sides is where it was in the last
 * image, which says nothing if it has hardly anything that goes on, as the first one of
 * a sensor under its cover. */
bool
RangeContinuity::isStill() const
{
  constexpr std::uint32_t every = 7;
  constexpr std::size_t share = 20;
  constexpr std::size_t least_share = 16;
  std::size_t seen = 0;
  std::size_t compared = 0;
  std::size_t moved = 0;
  const auto goes_on = [](const Code* code) {
    return *code >= 0 && std::abs(code[1] - *code) < row_width &&
           std::abs(code[-1] - *code) < row_width;
  };
  for (std::uint32_t row = 0; row < height_; ++row)
    for (std::uint32_t column = row % every; column < width_; column += every) {
      const Code* const now = at(image_, row) + column;
      const Code* const last = at(last_image_, row) + column;
      if (!goes_on(now))
        continue;
      ++seen;
      if (!goes_on(last))
        continue;
      ++compared;
      moved += std::abs(*now - *last) >= row_width ? 1 : 0;
    }
  return compared > 0 && least_share * compared >= seen && share * moved <= compared;
}

} // namespace pcl_ext::PCL_EXT_ABI
