// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "rate/rate_ladder.h"

#include <pcl_ext/filters/voxel_outlier_removal.h>

#include <algorithm>
#include <cmath>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

// Of the bytes of the step before, on the simulated robot cell; soon learned.
constexpr FrameRatios guess_of_effort{0.95, 0.95};
constexpr FrameRatios guess_of_filter{0.85, 0.25};
constexpr FrameRatios guess_of_longer_filter{1.0, 0.9};
constexpr FrameRatios guess_of_companding{0.9, 0.9};
constexpr FrameRatios guess_of_removal{0.85, 0.85};
constexpr FrameRatios guess_of_doubling{0.5, 0.35};

double
learned(double saving, double share)
{
  // Bytes of a better step are never fewer.
  return std::min(0.0, saving + share);
}

} // namespace

RateLadder::RateLadder(const EncoderSettings& settings,
                       bool has_intensities,
                       bool can_remove_outliers,
                       const std::optional<float>& min_log_odds)
{
  const bool is_version1 = settings.format == StreamFormat::Version1;
  RateStep step{settings.effort,
                settings.temporal_filter,
                settings.intensity_curve,
                settings.intensity_bits,
                min_log_odds,
                0};
  add(step, FrameRatios());
  if (settings.max_encode_ms > 0.0 && settings.max_rate > 0.0 && is_version1)
    while (step.effort != Effort::Small) {
      step.effort = step.effort == Effort::Fast ? Effort::Balanced : Effort::Small;
      add(step, guess_of_effort);
    }
  if (settings.max_rate > 0.0) {
    if (!settings.keepsPoints() && settings.fields.empty()) {
      const unsigned int strongest = settings.rate_temporal_filter;
      constexpr unsigned int usual = 8;
      if (step.temporal_filter < std::min(usual, strongest)) {
        step.temporal_filter = std::min(usual, strongest);
        add(step, guess_of_filter);
      }
      if (step.temporal_filter < strongest) {
        step.temporal_filter = strongest;
        add(step, guess_of_longer_filter);
      }
    }
    constexpr unsigned int few_bits = 4;
    if (is_version1 && has_intensities &&
        step.intensity_curve == IntensityCurve::Linear &&
        (step.intensity_bits == 0 || step.intensity_bits > few_bits)) {
      step.intensity_curve = IntensityCurve::Companded;
      step.intensity_bits = few_bits;
      add(step, guess_of_companding);
    }
    // Not where it is off: of sparse clouds it may remove all but a part.
    if (can_remove_outliers && min_log_odds && *min_log_odds < 0.0f &&
        VoxelOutlierRemoval::isMadeFor(settings.resolution)) {
      step.min_log_odds = 0.0f;
      add(step, guess_of_removal);
    }
  }
  const bool is_on = settings.max_rate > 0.0 || settings.max_encode_ms > 0.0;
  for (unsigned int i = 1; is_on && i <= settings.rate_doublings; ++i) {
    step.doublings = i;
    const EncoderSettings coarser = settingsOf(step, settings, std::nullopt);
    // They may be too large for an encoder.
    if (!checkSettings(coarser).ok())
      break;
    if (!VoxelOutlierRemoval::isMadeFor(coarser.resolution))
      step.min_log_odds.reset();
    add(step, guess_of_doubling);
  }
}

void
RateLadder::add(const RateStep& step, const FrameRatios& guess)
{
  steps_.push_back(step);
  savings_.push_back({std::log(guess.i_frame), std::log(guess.p_frame)});
}

FrameRatios
RateLadder::ratios(std::size_t from, std::size_t to) const
{
  double i_frame = 0.0;
  double p_frame = 0.0;
  for (std::size_t step = std::min(from, to) + 1; step <= std::max(from, to); ++step) {
    if (isIdle(step))
      continue;
    i_frame += savings_[step].i_frame;
    p_frame += savings_[step].p_frame;
  }
  const double sign = from <= to ? 1.0 : -1.0;
  return {std::exp(sign * i_frame), std::exp(sign * p_frame)};
}

RateStep
RateLadder::inForce(std::size_t step) const
{
  RateStep in_force = steps_[step];
  if (is_filter_idle_)
    in_force.temporal_filter = steps_[0].temporal_filter;
  return in_force;
}

bool
RateLadder::isLearned(std::size_t from, std::size_t to) const
{
  for (std::size_t step = to + 1; step <= from; ++step)
    if (!savings_[step].is_learned && !isIdle(step))
      return false;
  return true;
}

void
RateLadder::learn(std::size_t from, std::size_t to, const FrameRatios& observed)
{
  const FrameRatios expected = ratios(from, to);
  const double sign = from < to ? 1.0 : -1.0;
  const std::size_t first = std::min(from, to) + 1;
  const std::size_t last = std::max(from, to);
  double count = 0.0;
  for (std::size_t step = first; step <= last; ++step)
    count += isIdle(step) ? 0.0 : 1.0;
  constexpr double most = 20.0; // what more there is may be the scene
  const auto share = [&](double seen, double guessed) {
    return sign * std::log(std::clamp(seen / guessed, 1.0 / most, most)) / count;
  };
  for (std::size_t step = first; step <= last; ++step) {
    if (isIdle(step))
      continue;
    Saving& saving = savings_[step];
    saving.i_frame = learned(saving.i_frame, share(observed.i_frame, expected.i_frame));
    saving.p_frame = learned(saving.p_frame, share(observed.p_frame, expected.p_frame));
    saving.is_learned = true;
    saving.is_measured |= count == 1.0;
  }
}

EncoderSettings
settingsOf(const RateStep& step,
           const EncoderSettings& settings,
           const std::optional<VoxelGrid>& finest)
{
  EncoderSettings changed = settings;
  changed.effort = step.effort;
  // What was not asked for shows nothing that was not measured.
  if (settings.temporal_filter == 0 && step.temporal_filter != 0)
    changed.temporal_filter_holds = false;
  changed.temporal_filter = step.temporal_filter;
  changed.intensity_curve = step.intensity_curve;
  changed.intensity_bits = step.intensity_bits;
  if (step.doublings == 0)
    return changed;
  const double edge = finest ? finest->resolution : settings.resolution;
  changed.resolution = std::ldexp(edge, static_cast<int>(step.doublings));
  changed.use_coordinate_step = false;
  if (finest && settings.format == StreamFormat::Version1)
    changed.origin = finest->origin;
  return changed;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
