// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "simd/bit_operations.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief Deviations of the values of a stream from their running mean, by the size of
 * the mean: what a voxel's first deviation is taken from. Until values were learned
 * that of a count, its square root, times a factor if the first values vary much more.
 * All in 2^-8. */
class UsualDeviations {
public:
  /** \brief The usual deviation of values with a mean. */
  std::uint32_t
  operator()(std::uint32_t mean) const
  {
    return static_cast<std::uint32_t>(deviations_[bandOf(mean)] >> 8);
  }

  /** \brief Learns the deviation of a value from a mean. */
  void
  add(std::uint32_t mean, std::uint32_t deviation)
  {
    std::uint64_t& learned = deviations_[bandOf(mean)];
    learned += deviation - (learned >> 8);
  }

  /** \brief Learns the distance between a voxel's first two values. */
  void
  addFirst(std::uint32_t value, std::uint32_t distance)
  {
    if (first_count_ == least_first)
      return;
    first_distances_ += distance;
    first_deviations_ += (*this)(value);
    if (++first_count_ == least_first && first_distances_ > 4 * first_deviations_)
      for (std::uint64_t& deviation : deviations_)
        deviation = deviation * first_distances_ / first_deviations_;
  }

private:
  static constexpr unsigned int least_first = 1024;
  static constexpr std::size_t count = 50; // two bands for each doubling

  static std::size_t
  bandOf(std::uint32_t mean)
  {
    if (mean < 2)
      return 0;
    const unsigned int highest = highestBit(mean);
    return 2 * (highest - 1) + (mean >> (highest - 1) & 1);
  }

  static std::array<std::uint64_t, count>
  rootsOfMeans()
  {
    std::array<std::uint64_t, count> roots{};
    for (std::size_t band = 0; band < count; ++band) {
      // The root of a number of 2^-8 is one of 2^-4.
      const std::uint64_t mean = std::uint64_t{band % 2 == 0 ? 2u : 3u} << band / 2;
      std::uint64_t root = 0;
      while ((root + 1) * (root + 1) <= mean)
        ++root;
      roots[band] = root << (4 + 8);
    }
    return roots;
  }

  std::array<std::uint64_t, count> deviations_ = rootsOfMeans(); // 2^-16
  // Sums of first values.
  std::uint64_t first_distances_ = 0;
  std::uint64_t first_deviations_ = 0;
  unsigned int first_count_ = 0;
};

/** \brief A value of a voxel that noise changes from frame to frame: an intensity's
 * symbol or a channel of a colour. It is shown as it is as long as its running mean
 * stays within a part of the noise. */
class HeldValue {
public:
  /** \brief Takes the value of a frame.
   * \param[in] is_first whether it begins anew with it */
  void
  add(std::uint16_t value, bool is_first, UsualDeviations& usual)
  {
    frames_ = is_first ? 0 : frames_;
    const std::uint32_t scaled = std::uint32_t{value} << 8;
    const std::uint32_t distance = scaled > mean_ ? scaled - mean_ : mean_ - scaled;
    if (frames_ >= frames_until_usual)
      usual.add(mean_, distance);
    else if (frames_ == 1)
      usual.addFirst(mean_, distance);
    if (frames_ == 0 || distance > jump * deviation_ + one) {
      mean_ = scaled;
      deviation_ = usual(mean_);
      frames_ = 1;
      jumped_ = true;
      return;
    }
    frames_ = static_cast<std::uint8_t>(std::min(frames_ + 1u, most_frames));
    const auto step = static_cast<std::uint32_t>(
        std::uint64_t{distance} * reciprocals[frames_] >> 16);
    mean_ = scaled > mean_ ? mean_ + step : mean_ - step;
    deviation_ += distance / most_frames - deviation_ / most_frames;
  }

  /** \brief Begins again, with another value to show until add() is called. */
  void
  restart(std::uint16_t value)
  {
    *this = HeldValue();
    mean_ = std::uint32_t{value} << 8;
    shown_ = value;
  }

  /** \brief The value to show, which follows the mean when that has moved by more than
   * half of the deviation, and at once after a jump. */
  std::uint16_t
  shown()
  {
    const std::uint32_t now = std::uint32_t{shown_} << 8;
    const std::uint32_t distance = mean_ > now ? mean_ - now : now - mean_;
    if (jumped_ || distance > deviation_ / 2 + one / 2) // with rounding
      shown_ = static_cast<std::uint16_t>(std::min((mean_ + one / 2) >> 8, 0xffffu));
    jumped_ = false;
    return shown_;
  }

private:
  static constexpr unsigned int most_frames = 16; // of the running mean
  static constexpr int frames_until_usual = 4;    // of the mean, to learn from it
  static constexpr std::uint32_t jump = 5; // mean deviations: 4 standard deviations
  static constexpr std::uint32_t one = 1u << 8;

  /** \brief 2^16 / i, so that a division is a multiplication. */
  static constexpr std::array<std::uint32_t, most_frames + 1> reciprocals = [] {
    std::array<std::uint32_t, most_frames + 1> values{};
    for (std::uint32_t i = 1; i <= most_frames; ++i)
      values[i] = 0x10000 / i;
    return values;
  }();

  std::uint32_t mean_ = 0;      // 2^-8
  std::uint32_t deviation_ = 0; // mean of the absolute ones, 2^-8
  std::uint16_t shown_ = 0;
  std::uint8_t frames_ = 0; // of the mean
  bool jumped_ = false;
};

} // namespace pcl_ext::PCL_EXT_ABI
