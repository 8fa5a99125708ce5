// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/rate_control_status.h>
#include <pcl_ext/compression/voxel_grid.h>

#include "rate/rate_estimate.h"
#include "rate/rate_ladder.h"

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Chooses the step of the ladder by what frames take; see RateControl. */
class StepChoice {
public:
  using Nanoseconds = std::chrono::nanoseconds;

  /** \brief The first step; parameters are those of RateControl. */
  StepChoice(const EncoderSettings& settings,
             bool has_intensities,
             bool can_remove_outliers,
             const std::optional<float>& min_log_odds);

  /** \brief Lets time pass, 0 or more.
   * \param[in] max_rate in it, bits a second; 0: no limit
   */
  void
  advance(Nanoseconds elapsed, double max_rate);

  /** \brief Takes another step where frames take too much, or less again.
   * \param[in] is_short there is no room for the next frame
   */
  void
  choose(bool is_short);

  /** \brief Learns from a frame on the step.
   * \param[in] grid of the frame
   * \param[in] sensor_motion of its sensor: only of one at rest the filter saves bytes
   */
  void
  endFrame(const VoxelGrid& grid, SensorMotion sensor_motion);

  /** \brief Takes it that the last frame, as endFrame() has been told of it, is larger
   * than a whole buffer: the step is left at once where the buffer of the mean rate is
   * no larger. */
  void
  setTooLarge(std::size_t bytes)
  {
    too_large_ = bytes;
  }

  /** \brief What frames take; fed by the caller. */
  RateEstimate&
  estimate()
  {
    return estimate_;
  }

  const RateEstimate&
  estimate() const
  {
    return estimate_;
  }

  /** \brief Share of the rate that frames take, 1: all of it. */
  double
  load() const
  {
    return loadOf(step_);
  }

  /** \brief Whether the step is another than for the last frame. */
  bool
  hasChanged() const
  {
    return has_changed_;
  }

  /** \brief The settings of the step. */
  const EncoderSettings&
  settings() const
  {
    return settings_;
  }

  /** \brief The step, with an effort that max_encode_ms allows. */
  const RateStep&
  step() const
  {
    return effective_;
  }

  /** \brief Sets what a status tells of the step. */
  void
  describe(RateControlStatus& status) const;

  /** \brief Why clouds are left out; empty: they need not be. */
  const std::string&
  rateNotKept() const
  {
    return rate_not_kept_;
  }

private:
  struct Change {
    std::size_t from = 0;
    double i_frame = 0.0; // bytes before
    double p_frame = 0.0;
  };

  double
  loadOf(std::size_t step) const;

  bool
  fits(std::size_t step, double share) const;

  double
  bufferBytes() const;

  bool
  hasHeld() const;

  bool
  keepEncodeTime();

  bool
  goDownInTime(const std::string& reason);

  std::size_t
  stepOfDoublings(unsigned int doublings) const;

  void
  keepRate(bool is_short);

  std::string
  overload() const;

  void
  goDown();

  void
  goUp();

  void
  change(std::size_t step, const std::string& reason);

  void
  take(std::size_t step, const std::string& reason);

  void
  followMotion();

  void
  learnFromChange();

  EncoderSettings base_;     // of the first step
  EncoderSettings settings_; // of the step
  RateLadder ladder_;
  RateEstimate estimate_;
  RateStep effective_;
  std::size_t step_ = 0;
  std::size_t least_step_ = 0; // that time allows
  Effort effort_limit_ = Effort::Small;
  std::optional<VoxelGrid> finest_; // of frames without doublings
  Nanoseconds time_{0};
  double max_rate_ = 0.0;      // bits a second
  double mean_rate_ = 0.0;     // of that
  double fall_a_second_ = 0.0; // of the mean
  Nanoseconds changed_at_{0};
  std::optional<Nanoseconds> up_at_;      // the last change to a better step
  std::optional<Nanoseconds> over_since_; // too much for the step
  Nanoseconds hold_;
  std::size_t too_large_ = 0;           // bytes of the last frame; 0: it had room
  bool has_rested_ = false;             // the sensor, in some frame
  std::optional<Nanoseconds> moved_at_; // in which it last moved
  std::optional<Change> change_;        // not learned from yet
  bool has_changed_ = false;
  std::size_t changes_ = 0;
  std::string reason_ = "at the start of the stream";
  std::string rate_not_kept_;
  std::string time_not_kept_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
