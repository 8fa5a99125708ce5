// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/rate_control_status.h>

#include "rate/rate_estimate.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The steps that rate control chooses from, and what they save.
 *
 * How many bytes a step takes of those of the one before is guessed at first, and learned
 * where the stream has been on both. */
class RateLadder {
public:
  /** \brief The steps from settings down to what RateSettings allow, best quality first;
   * see RateControl. */
  RateLadder(const EncoderSettings& settings,
             bool has_intensities,
             bool can_remove_outliers,
             const std::optional<float>& min_log_odds);

  std::size_t
  size() const
  {
    return steps_.size();
  }

  const RateStep&
  operator[](std::size_t step) const
  {
    return steps_[step];
  }

  /** \brief Bytes on a step, of those on another one. */
  FrameRatios
  ratios(std::size_t from, std::size_t to) const;

  /** \brief Whether ratios() from a step to a better one is more than a guess. */
  bool
  isLearned(std::size_t from, std::size_t to) const;

  /** \brief Whether what a step saves was seen by itself, from the step before or to
   * it, not as a share of what several save. */
  bool
  isMeasured(std::size_t step) const
  {
    return isIdle(step) || savings_[step].is_measured;
  }

  /** \brief Says that steps of the temporal filter save nothing and are not taken, as the
   * sensor moves. */
  void
  setFilterIdle(bool is_idle)
  {
    is_filter_idle_ = is_idle;
  }

  bool
  isFilterIdle() const
  {
    return is_filter_idle_;
  }

  /** \brief What of a step is in force. */
  RateStep
  inForce(std::size_t step) const;

  /** \brief Learns from bytes before and after a change of the step. */
  void
  learn(std::size_t from, std::size_t to, const FrameRatios& ratios);

private:
  void
  add(const RateStep& step, const FrameRatios& guess);

  /** \brief Whether a step is that of the temporal filter, and not taken. */
  bool
  isIdle(std::size_t step) const
  {
    return is_filter_idle_ && step > 0 &&
           steps_[step].temporal_filter != steps_[step - 1].temporal_filter;
  }

  /** \brief Logarithms of ratios of a step to the one before. */
  struct Saving {
    double i_frame = 0.0;
    double p_frame = 0.0;
    bool is_learned = false;
    bool is_measured = false;
  };

  std::vector<RateStep> steps_;
  std::vector<Saving> savings_;
  bool is_filter_idle_ = false;
};

/** \brief The settings of a step.
 * \param[in] finest grid of the frames on the first step, if there were any: coarse
 * voxels are made of its voxels
 */
EncoderSettings
settingsOf(const RateStep& step,
           const EncoderSettings& settings,
           const std::optional<VoxelGrid>& finest);

} // namespace pcl_ext::PCL_EXT_ABI::io
