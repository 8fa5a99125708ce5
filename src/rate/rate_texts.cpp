// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "rate/rate_texts.h"

#include <iomanip>
#include <locale>
#include <sstream>

namespace pcl_ext::PCL_EXT_ABI::io {

std::string
numberText(double number)
{
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::setprecision(number >= 100.0 ? 0 : 3);
  if (number >= 100.0)
    text << std::fixed;
  text << number;
  return text.str();
}

std::string
rateText(double bits_per_second)
{
  constexpr double kilo = 1e3;
  constexpr double mega = 1e6;
  return bits_per_second < mega ? numberText(bits_per_second / kilo) + " kbit/s"
                                : numberText(bits_per_second / mega) + " Mbit/s";
}

std::string
stepText(const RateStep& step, double resolution)
{
  std::string text = "voxels of " + numberText(resolution) + " m, effort " +
                     nameOf(efforts, step.effort);
  if (step.temporal_filter > 0)
    text += ", temporal filter of " + std::to_string(step.temporal_filter);
  if (step.intensity_curve == IntensityCurve::Companded)
    text += ", " + std::to_string(step.intensity_bits) + " companded bits";
  if (step.min_log_odds)
    text += ", outliers removed at " + numberText(*step.min_log_odds);
  return text;
}

std::string
overloadText(double bytes_per_second,
             double i_frame_bytes,
             double max_rate,
             double buffer_seconds)
{
  std::string text = "frames take " + rateText(8.0 * bytes_per_second) + " of " +
                     rateText(max_rate) + " at most";
  const double buffer_bytes = max_rate / 8.0 * buffer_seconds;
  if (i_frame_bytes > buffer_bytes)
    text += ", I-frames " + numberText(i_frame_bytes / 1e3) + " kB of the " +
            numberText(buffer_bytes / 1e3) + " kB that the buffer lets them take";
  return text;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
