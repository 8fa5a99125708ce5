// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>

#include <cstddef>
#include <optional>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \addtogroup io
 * @{ */

/** \brief A step of the ladder that the rate control chooses from, see
 * doc/rate_control.md. */
struct RateStep {
  Effort effort = Effort::Fast;
  unsigned int temporal_filter = 0;
  IntensityCurve intensity_curve = IntensityCurve::Linear;
  unsigned int intensity_bits = 0;
  /** \brief Of an outlier removal before the frame is encoded; none: no removal. */
  std::optional<float> min_log_odds;
  unsigned int doublings = 0; ///< of the voxel edge

  friend bool
  operator==(const RateStep& a, const RateStep& b)
  {
    return a.effort == b.effort && a.temporal_filter == b.temporal_filter &&
           a.intensity_curve == b.intensity_curve &&
           a.intensity_bits == b.intensity_bits && a.min_log_odds == b.min_log_odds &&
           a.doublings == b.doublings;
  }

  friend bool
  operator!=(const RateStep& a, const RateStep& b)
  {
    return !(a == b);
  }
};

/** \brief What the rate control chose, and why. */
struct RateControlStatus {
  bool is_on = false;
  double max_rate = 0.0;       ///< bits a second; 0: no limit
  double used_rate = 0.0;      ///< likewise, of the frames of the last second
  double encode_ms = 0.0;      ///< mean of the last frames; 0: none
  RateStep step;               ///< in force
  double resolution = 0.0;     ///< voxel edge on it, metres
  std::size_t step_number = 0; ///< 0: the settings as they are
  std::size_t last_step = 0;   ///< the number of the coarsest one
  std::size_t changes = 0;     ///< of the step
  std::size_t clouds_left_out = 0;
  std::string choice; ///< the step in words
  std::string reason; ///< why it was chosen
  /** \brief What budget is not kept by the step alone: clouds are left out for
   * max_rate, or max_encode_ms is exceeded on the coarsest step. Empty: both are kept.
   */
  std::string not_kept;
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::io
