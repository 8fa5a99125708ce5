// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Frames from one I-frame to the next, 1 or more.
 * \param[in] interval from one cloud to the next, seconds; 0: not known
 */
inline double
framesOfIFrame(const StreamSettings& settings, double interval)
{
  const double by_count = std::max(settings.i_frame_rate, 1u);
  if (settings.i_frame_every == 0.0 || interval <= 0.0)
    return by_count;
  return std::clamp(std::ceil(settings.i_frame_every / interval), 1.0, by_count);
}

/** \brief Share of a rate, and of its buffer, above which frames are too large for it. */
constexpr double most_rate_load = 0.95;

/** \brief The least max_rate at which rate control keeps frames as they are and leaves
 * out none, bits a second.
 * \param[in] interval from one cloud to the next, seconds, above 0
 * \param[in] p_frame_bytes of the largest
 */
inline double
leastRate(const EncoderSettings& settings,
          double interval,
          double i_frame_bytes,
          double p_frame_bytes)
{
  const double between = framesOfIFrame(settings, interval);
  const auto bytes_of = [&](double frames) {
    const double i_frames = std::ceil(frames / between);
    return i_frames * i_frame_bytes + (frames - i_frames) * p_frame_bytes;
  };
  const double second = bytes_of(std::max(std::ceil(1.0 / interval - 1e-6), 1.0));
  const double mean = bytes_of(between) / (between * interval);
  return 8.0 * std::max({second,
                         mean / most_rate_load,
                         i_frame_bytes / (settings.rate_buffer * most_rate_load)});
}

/** \brief What I- and P-frames take of others. */
struct FrameRatios {
  double i_frame = 1.0;
  double p_frame = 1.0;
};

/** \brief What the next frames of a stream are expected to take: running means of its
 * last ones, of I- and P-frames apart. */
class RateEstimate {
public:
  using Nanoseconds = std::chrono::nanoseconds;

  /** \param[in] stream when it has I-frames */
  explicit RateEstimate(const StreamSettings& stream) : stream_(stream) {}

  /** \brief Adds the time from one cloud to the next, 0 or more. Pauses do not count. */
  void
  addInterval(Nanoseconds interval)
  {
    const double seconds = std::chrono::duration<double>(interval).count();
    if (seconds < 2.0)
      interval_.add(seconds);
  }

  void
  addFrame(std::size_t bytes, bool is_i_frame, Nanoseconds encode_time)
  {
    (is_i_frame ? i_frame_ : p_frame_).add(static_cast<double>(bytes));
    encode_ms_.add(std::chrono::duration<double, std::milli>(encode_time).count());
    ++frames_;
  }

  /** \brief Expects frames to take a multiple from now on. */
  void
  expectMultiple(const FrameRatios& ratios)
  {
    // Both are expected, also where one was not seen.
    const double i_frame = bytesOf(true) * ratios.i_frame;
    const double p_frame = bytesOf(false) * ratios.p_frame;
    i_frame_.expect(i_frame);
    p_frame_.expect(p_frame);
  }

  /** \brief The same after a change of the settings. */
  void
  scale(const FrameRatios& ratios)
  {
    expectMultiple(ratios);
    encode_ms_ = Mean();
    frames_ = 0;
  }

  /** \brief Bytes of an I- or P-frame; 0: not known. */
  double
  bytesOf(bool is_i_frame) const
  {
    // As on the first frames of the simulated cell.
    constexpr double p_frame_of_i_frame = 0.8;
    if (is_i_frame)
      return i_frame_.count > 0 ? i_frame_.value : p_frame_.value / p_frame_of_i_frame;
    return p_frame_.count > 0 ? p_frame_.value : i_frame_.value * p_frame_of_i_frame;
  }

  /** \brief Whether the size of P-frames is known by frames, also by those of another
   * step. */
  bool
  knowsPFrames() const
  {
    return p_frame_.count > 0;
  }

  /** \brief If no cloud is left out, and frames take a multiple; 0: not known. */
  double
  bytesPerSecond(const FrameRatios& ratios = FrameRatios()) const
  {
    if (interval_.value <= 0.0)
      return 0.0;
    const double frames = framesOfIFrame(stream_, interval_.value);
    const double bytes = bytesOf(true) * ratios.i_frame +
                         (frames - 1.0) * bytesOf(false) * ratios.p_frame;
    return bytes / (frames * interval_.value);
  }

  /** \brief From one cloud to the next. */
  Nanoseconds
  interval() const
  {
    return std::chrono::duration_cast<Nanoseconds>(
        std::chrono::duration<double>(interval_.value));
  }

  double
  encodeMs() const
  {
    return encode_ms_.value;
  }

  /** \brief Number of frames since the last change of the settings. */
  unsigned int
  frames() const
  {
    return frames_;
  }

private:
  /** \brief A mean that follows the last values. */
  struct Mean {
    void
    add(double next)
    {
      constexpr unsigned int most = 8;
      count = std::min(count + 1, most);
      value += (next - value) / count;
    }

    void
    expect(double expected)
    {
      // It has the weight of a value.
      value = expected;
      count = expected > 0.0 ? 1 : 0;
    }

    double value = 0.0;
    unsigned int count = 0;
  };

  StreamSettings stream_;
  Mean i_frame_;
  Mean p_frame_;
  Mean interval_; // seconds
  Mean encode_ms_;
  unsigned int frames_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
