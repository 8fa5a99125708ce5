// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief Log-odds of surface against noise in the air for each pixel of a lidar's
 * image, from the ranges of the pixels around it (doc/outlier_removal.md, "Points of
 * lidars"). Ranges are logarithms of integers, so that a tolerance is a share of the
 * range at any distance. */
class RangeContinuity {
public:
  RangeContinuity();

  /** \brief Computes the log-odds of an image.
   * \param[in] ranges metres, row after row, of rows next to each other; 0: no return.
   * The first column is next to the last one
   * \param[in] uses_last also use the last image, if it has the same size and the sensor
   * has not moved since
   * \param[out] log_odds of each pixel, 0 without a return
   */
  void
  score(const std::vector<float>& ranges,
        std::uint32_t width,
        std::uint32_t height,
        bool uses_last,
        std::vector<float>& log_odds);

  /** \brief Forgets the last image. */
  void
  reset()
  {
    has_last_ = false;
    width_ = 0;
    height_ = 0;
  }

private:
  /** \brief 1000 ln(1 + range / 2 m), or no_return. */
  using Code = std::int16_t;

  static constexpr double codes_of_one = 1000.0;
  static constexpr float near_range = 2.0f;       ///< metres
  static constexpr std::size_t table_size = 8192; ///< eight octaves of 1 + range / 2 m
  static constexpr Code no_return = -16000;
  static constexpr std::uint32_t chunk = 64; ///< columns that are judged at once
  static constexpr std::uint32_t margin = 4; ///< columns at both ends of a row
  static constexpr Code row_width = 20;      ///< 0.02
  static constexpr Code column_width = 50;   ///< 0.05
  static constexpr Code farthest = 1000;     ///< 1
  static constexpr Code beyond_sight = 300;  ///< 0.3, of a ray without a return
  static constexpr std::uint32_t row_neighbours = 8;
  static constexpr int column_neighbours = 4;

  void
  resize(std::uint32_t width, std::uint32_t height);

  void
  encode(const float* ranges, std::uint32_t row);

  static void
  addSupport(const Code* centre, const Code* other, Code* sum);

  static void
  addBestSupport(const Code* centre, const Code* other, Code* sum);

  static void
  addDepth(const Code* centre, const Code* other, Code* sum);

  void
  judge(std::uint32_t row, std::uint32_t column, bool uses_last, float* log_odds) const;

  float
  seenBefore(std::uint32_t row, std::uint32_t column, Code code) const;

  bool
  isStill() const;

  const Code*
  at(const std::vector<Code>& image, std::uint32_t row) const
  {
    return image.data() + row * stride_ + margin;
  }

  std::array<Code, table_size> codes_;
  std::array<float, row_neighbours * row_width + 1> row_terms_;
  std::uint32_t width_ = 0;
  std::uint32_t height_ = 0;
  std::size_t stride_ = 0; // of a row with its margins, in whole chunks
  std::vector<Code> image_;
  std::vector<Code> last_image_;
  bool has_last_ = false;
};

} // namespace pcl_ext::PCL_EXT_ABI
