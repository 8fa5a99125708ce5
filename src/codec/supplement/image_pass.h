// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/impl/point_image.h>
#include <pcl_ext/compression/voxel_grid.h>

#include "codec/supplement/field_numbers.h"
#include "codec/supplement/image.h"
#include "voxels/rays.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace supplement {

/** \brief Codes the depths of the points of an image, and how far their voxels are from
 * their rays. */
template <class CodingT>
class ImagePass {
public:
  /** \param[in] past means of the last frames; empty: none */
  ImagePass(const PointImage& image,
            unsigned int grid_depth,
            ImageModels& models,
            const std::vector<std::uint32_t>& past,
            std::vector<std::uint32_t>& next_past)
  : image_(image)
  , reader_(image)
  , grid_size_(std::int64_t{1} << grid_depth)
  , sensor_voxel_(sensorVoxel(image.rays.pose))
  , models_(models)
  , past_(past)
  , next_past_(next_past)
  , errors_(std::size_t{image.width} + 1)
  {}

  /** \brief Codes all pixels.
   * \param[in] point_count how many of them have points
   * \param[in,out] points the decoder appends their keys and sets their depths
   */
  bool
  run(CodingT& coding, std::uint64_t point_count, PixelPoints& points)
  {
    CodingT local = coding; // in registers
    std::size_t point = 0;
    for (std::uint32_t row = 0; row < image_.height; ++row) {
      reader_.moveTo(row);
      // Row by row, so that a forged size takes no more memory than there are bytes for.
      next_past_.resize((row + std::size_t{1}) * image_.width);
      if constexpr (CodingT::is_decoder)
        points.depths.resize(next_past_.size());
      depths_ = points.depths.data();
      for (std::uint32_t column = 0; column < image_.width; ++column) {
        const std::size_t pixel = std::size_t{row} * image_.width + column;
        const Around around = aroundOf(row, column, pixel);
        if (!codeIsPoint(local, around, column, pixel)) {
          // Bits are decoded without end, so that there is no other way to notice it.
          if (local.isOverrun())
            return false;
          continue;
        }
        if (point == point_count)
          return false;
        if constexpr (CodingT::is_decoder)
          points.keys.push_back(0);
        bool is_at_sensor = false;
        if (image_.has_points_at_sensor &&
            !codeIsAtSensor(
                local, around, column, pixel, points.keys[point], is_at_sensor))
          return false;
        if (is_at_sensor) {
          ++point;
          continue;
        }
        if (!codeDepth(local, around, column, pixel) ||
            !codeVoxel(local, column, depths_[pixel], points.keys[point]))
          return false;
        ++point;
      }
    }
    coding = local;
    return point == point_count;
  }

private:
  /** \brief What the depth of a pixel is expected from. */
  enum Source : std::size_t { from_edge, from_mean, from_past, source_count };

  /** \brief Errors of the depths that were expected of a pixel, by source. */
  using Errors = std::array<std::uint32_t, source_count>;

  /** \brief Depths of the pixels around one, or no_depth. */
  struct Around {
    std::uint32_t left;
    std::uint32_t up;
    std::uint32_t up_left;
    std::uint32_t up_right;
  };

  Around
  aroundOf(std::uint32_t row, std::uint32_t column, std::size_t pixel) const
  {
    const std::size_t width = image_.width;
    const bool has_left = column > 0;
    const bool has_right = column + 1 < width;
    const auto depth = [&](bool is_inside, std::size_t distance) {
      const std::uint32_t other = is_inside ? depths_[pixel - distance] : no_depth;
      return other == sensor_depth ? no_depth : other;
    };
    return {depth(has_left, 1),
            depth(row > 0, width),
            depth(row > 0 && has_left, width + 1),
            depth(row > 0 && has_right, width - 1)};
  }

  std::uint32_t
  pastAt(std::size_t pixel) const
  {
    return past_.empty() ? no_depth : past_[pixel];
  }

  /** \brief Which of the pixels around have points, and had them before. */
  std::size_t
  contextOf(const Around& around, std::uint32_t column, std::size_t pixel) const
  {
    const auto is = [](std::uint32_t depth) { return depth != no_depth ? 1u : 0u; };
    return is(around.left) | is(around.up) << 1 | is(around.up_left) << 2 |
           is(around.up_right) << 3 | is(pastAt(pixel)) << 4 |
           (column + 1 < image_.width ? is(pastAt(pixel + 1)) : 0u) << 5;
  }

  /** \brief Codes whether a pixel has a point. */
  bool
  codeIsPoint(CodingT& coding,
              const Around& around,
              std::uint32_t column,
              std::size_t pixel)
  {
    const std::size_t context = contextOf(around, column, pixel);
    coding.reserve(1);
    const bool is_point =
        coding.codeBit(models_.is_point[context], depths_[pixel] != no_depth);
    if (CodingT::is_decoder)
      depths_[pixel] = is_point ? 0 : no_depth;
    if (!is_point)
      next_past_[pixel] = no_depth;
    return is_point;
  }

  /** \brief Codes whether the point of a pixel is in the voxel of the sensor; then it
   * counts as none for what comes after it.
   * \param[in,out] key of the point's voxel; the decoder sets it
   * \return false if that is outside the grid
   */
  bool
  codeIsAtSensor(CodingT& coding,
                 const Around& around,
                 std::uint32_t column,
                 std::size_t pixel,
                 std::uint64_t& key,
                 bool& is_at_sensor)
  {
    if constexpr (!CodingT::is_decoder) {
      const VoxelPosition voxel = voxelPosition(key);
      is_at_sensor = Triple{voxel.x, voxel.y, voxel.z} == sensor_voxel_;
    }
    coding.reserve(1);
    is_at_sensor = coding.codeBit(
        models_.is_at_sensor[contextOf(around, column, pixel)], is_at_sensor);
    if (!is_at_sensor)
      return true;
    depths_[pixel] = sensor_depth;
    next_past_[pixel] = no_depth;
    return !CodingT::is_decoder || setKey(sensor_voxel_, key);
  }

  /** \brief What is expected, with the depths that there are in the place of others.
   * \param[out] gradient how much the depths around a pixel differ
   */
  std::array<std::int32_t, source_count>
  expect(Around around, std::uint32_t past, std::uint32_t& gradient) const
  {
    const auto first = [](std::uint32_t depth, std::uint32_t other) {
      return depth != no_depth ? depth : other;
    };
    const std::uint32_t above =
        first(around.up, first(around.up_left, first(around.up_right, last_)));
    around.left = first(around.left, above);
    around.up = first(around.up,
                      around.up_left == no_depth ? first(around.up_right, around.left)
                                                 : around.left);
    around.up_left = first(around.up_left, around.up);
    around.up_right = first(around.up_right, around.up);
    const auto left = static_cast<std::int32_t>(around.left);
    const auto up = static_cast<std::int32_t>(around.up);
    const auto up_left = static_cast<std::int32_t>(around.up_left);
    const auto up_right = static_cast<std::int32_t>(around.up_right);
    gradient = static_cast<std::uint32_t>(
        std::abs(left - up_left) + std::abs(up - up_left) + std::abs(up_right - up));
    const std::int32_t edge =
        std::clamp(left + up - up_left, std::min(left, up), std::max(left, up));
    const std::int32_t mean = (2 * (left + up) + up_right - up_left + 2) >> 2;
    return {edge, mean, static_cast<std::int32_t>((past + 8) / 16)};
  }

  bool
  codeDepth(CodingT& coding,
            const Around& around,
            std::uint32_t column,
            std::size_t pixel)
  {
    const std::uint32_t past = pastAt(pixel);
    std::uint32_t gradient = 0;
    const std::array<std::int32_t, source_count> expected =
        expect(around, past, gradient);
    const std::size_t known = past == no_depth ? source_count - 1 : source_count;
    std::size_t best = 0;
    for (std::size_t source = 1; source < known; ++source)
      if (costs_[source] < costs_[best])
        best = source;
    const std::uint32_t error =
        errors_[column][best] + errors_[column + 1][best] + left_errors_[best];
    const std::size_t context =
        std::min<std::size_t>(bitLength(gradient), ImageModels::gradient_classes - 1) *
            ImageModels::error_classes +
        errorClass(error);
    coding.reserve(most_wide_symbols);
    const auto wide = static_cast<std::uint64_t>(std::int64_t{expected[best]});
    std::uint64_t folded =
        CodingT::is_decoder ? 0 : foldDifference(depths_[pixel], wide);
    if (!codeWide(coding, models_.depths[context], models_.wide, folded))
      return false;
    const std::uint64_t depth = unfoldDifference(folded, wide);
    if (depth >= depth_end)
      return false;
    last_ = static_cast<std::uint32_t>(depth);
    depths_[pixel] = last_;
    for (std::size_t source = 0; source < known; ++source)
      learnError(source, expected[source], column);
    learnPast(pixel, past);
    return true;
  }

  /** \brief Two classes for each doubling of an error from 32 on. */
  static std::size_t
  errorClass(std::uint32_t error)
  {
    const std::uint32_t size = error / 8;
    if (size < 4)
      return size;
    const unsigned int length = bitLength(size);
    return std::min<std::size_t>(2 * length - 2 + (size >> (length - 2) & 1),
                                 ImageModels::error_classes - 1);
  }

  /** \brief Learns how far the last depth is from what was expected. */
  void
  learnError(std::size_t source, std::int32_t expected, std::uint32_t column)
  {
    const std::int32_t difference = static_cast<std::int32_t>(last_) - expected;
    const std::uint32_t error = 8 * static_cast<std::uint32_t>(std::abs(difference));
    std::uint32_t& above = errors_[column][source];
    above = (above + 3 * error) / 4;
    left_errors_[source] = (left_errors_[source] + error) / 2;
    costs_[source] += 256 * bitLength(error) - costs_[source] / 256;
  }

  /** \brief Learns the last depth as one of its pixel.
   * \param[in] past mean before
   */
  void
  learnPast(std::size_t pixel, std::uint32_t past)
  {
    constexpr std::uint32_t far = 16 * 16;
    const std::uint32_t now = 16 * last_;
    const bool is_near = past != no_depth && now + far > past && past + far > now;
    next_past_[pixel] = is_near ? (3 * past + now + 2) / 4 : now;
  }

  /** \brief Codes the voxel of a point.
   * \param[in,out] key its Morton key; the decoder sets it
   */
  bool
  codeVoxel(CodingT& coding,
            std::uint32_t column,
            std::uint32_t depth,
            std::uint64_t& key)
  {
    const Ray ray = reader_.at(column);
    Triple expected;
    std::int64_t margin = ImageModels::margin_classes - 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t place = ray.at(depth, axis);
      expected[axis] = place >> 32;
      const std::int64_t part = place >> 28 & 15;
      margin = std::min(margin, std::min(part, 15 - part));
    }
    Triple voxel{};
    if constexpr (!CodingT::is_decoder) {
      const VoxelPosition position = voxelPosition(key);
      voxel = {position.x, position.y, position.z};
    }
    const std::size_t misses =
        std::min<std::size_t>(miss_rate_ / 64, ImageModels::miss_classes - 1);
    coding.reserve(1 + 3 * most_wide_symbols);
    const bool is_on_ray =
        coding.codeBit(models_.is_on_ray[misses * ImageModels::margin_classes +
                                         static_cast<std::size_t>(margin)],
                       voxel == expected);
    miss_rate_ += (is_on_ray ? 0u : 16u) - miss_rate_ / 16;
    if (is_on_ray)
      voxel = expected;
    for (std::size_t axis = 0; axis < 3 && !is_on_ray; ++axis)
      if (!codeOffset(coding,
                      models_.offsets[axis * ImageModels::miss_classes + misses],
                      expected[axis],
                      voxel[axis]))
        return false;
    return !CodingT::is_decoder || setKey(voxel, key);
  }

  /** \brief Codes how far a voxel is from the expected one on one axis. */
  bool
  codeOffset(CodingT& coding,
             rans::NibbleModel& lengths,
             std::int64_t expected,
             std::int64_t& position)
  {
    const auto wide = static_cast<std::uint64_t>(expected);
    std::uint64_t folded =
        CodingT::is_decoder
            ? 0
            : foldDifference(static_cast<std::uint64_t>(position), wide);
    const bool is_number = codeWide(coding, lengths, models_.wide, folded);
    position = static_cast<std::int64_t>(unfoldDifference(folded, wide));
    return is_number;
  }

  /** \brief Sets the key of a decoded voxel.
   * \return false if it is outside the grid
   */
  bool
  setKey(const Triple& voxel, std::uint64_t& key) const
  {
    for (const std::int64_t position : voxel)
      if (position < 0 || position >= grid_size_)
        return false;
    key = mortonKey({static_cast<std::uint32_t>(voxel[0]),
                     static_cast<std::uint32_t>(voxel[1]),
                     static_cast<std::uint32_t>(voxel[2])});
    return true;
  }

  const PointImage& image_;
  RayReader reader_;
  std::int64_t grid_size_;
  Triple sensor_voxel_;
  ImageModels& models_;
  const std::vector<std::uint32_t>& past_;
  std::vector<std::uint32_t>& next_past_;
  std::uint32_t* depths_ = nullptr;
  std::uint32_t last_ = 0; // depth
  /** \brief Means of the last errors of each column, in eighths, and those of the row. */
  std::vector<Errors> errors_;
  Errors left_errors_{};
  /** \brief 65536 times the mean length of the last errors, 256 or so. */
  Errors costs_{};
  /** \brief 256 times the share of voxels that were not on the ray. */
  std::uint32_t miss_rate_ = 128;
};

} // namespace supplement
} // namespace io
} // namespace pcl_ext
