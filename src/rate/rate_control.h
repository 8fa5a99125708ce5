// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/rate_control_status.h>
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/status.h>

#include "rate/cloud_clock.h"
#include "rate/link_budget.h"
#include "rate/step_choice.h"

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Keeps a stream within a budget: at most so many bits a second, and about so
 * many milliseconds a frame, see RateSettings.
 *
 * Frames never take more than max_rate in any second, nor more at once than the buffer
 * holds. So that few are left out, steps of a ladder are taken, best quality first:
 * - the settings as they are;
 * - higher efforts, if max_encode_ms is set, as far as it allows;
 * - the temporal filter, up to rate_temporal_filter, where the sensor rests;
 * - 4 companded bits for intensities;
 * - the removal of outliers at log-odds 0, where the caller removes milder ones;
 * - leaving clouds out, as long as rate_sent_share of them is sent;
 * - voxels of twice the edge, up to rate_doublings times, made of voxels of the finest
 *   grid, each time with clouds left out before the next time.
 *
 * It goes down where the frames of the last step would take more than 95 % of the budget
 * for a second, or sooner where one finds no room; and up where they would take
 * less than 75 % on a better step, 2 seconds after the last change. A step that had to be
 * left within 10 seconds is tried again after twice the time, up to a minute. How much a
 * step saves is learned from the stream; a better step of which only a guess says that it
 * would not fit is tried once, after 30 seconds.
 *
 * With max_encode_ms 0 all depends on times and sizes of the frames alone, and is the
 * same on all machines. The sizes are those of the frames; what a transport adds is not
 * counted. An instance serves one stream and one thread.
 *
 * For each cloud call beginCloud(); unless it says that the cloud is left out, encode it
 * with settings() and minLogOdds(), and send the frame if endFrame() says so.
 */
class RateControl {
public:
  using Nanoseconds = std::chrono::nanoseconds;

  /** \brief A control at the start of a stream.
   * \param[in] settings of the best step, as accepted by checkSettings()
   * \param[in] has_intensities whether frames will have intensities
   * \param[in] can_remove_outliers whether the caller removes outliers as minLogOdds()
   * says
   * \param[in] min_log_odds of the best step
   */
  explicit RateControl(const EncoderSettings& settings,
                       bool has_intensities = true,
                       bool can_remove_outliers = false,
                       const std::optional<float>& min_log_odds = std::nullopt);

  /** \brief Changes max_rate, as the link does.
   * \param[in] bits_per_second above 0; without a max_rate in the settings, and for
   * others, nothing changes
   */
  void
  setMaxRate(double bits_per_second);

  /** \brief Begins a cloud, for which the step may change.
   * \param[in] time of the cloud, of any clock; where it is up to a second earlier than
   * the latest, it counts as that, and where it is earlier still, time goes on from it
   * \param[in] is_i_frame_due whether it will be an I-frame
   * \return false: there is no room for it, and the caller leaves it out
   */
  bool
  beginCloud(Nanoseconds time, bool is_i_frame_due);

  /** \brief Whether settings() or minLogOdds() are others than for the last frame that
   * endFrame() was called for. */
  bool
  hasChanged() const
  {
    return choice_.hasChanged();
  }

  /** \brief The settings of the step; temporal_filter, intensity_curve, intensity_bits,
   * effort, resolution and origin may differ from those of the best one. */
  const EncoderSettings&
  settings() const
  {
    return choice_.settings();
  }

  /** \brief Threshold of the outlier removal; none: no removal. */
  const std::optional<float>&
  minLogOdds() const
  {
    return choice_.step().min_log_odds;
  }

  /** \brief Ends a frame that was encoded.
   * \param[in] bytes its size
   * \param[in] is_i_frame what it became
   * \param[in] encode_time it took from points to bytes
   * \param[in] grid of the frame
   * \param[in] sensor_motion of the frame's statistics
   * \return false: it is larger than the room there is; the caller must not send it,
   * and makes the next frame an I-frame
   */
  bool
  endFrame(std::size_t bytes,
           bool is_i_frame,
           Nanoseconds encode_time,
           const VoxelGrid& grid,
           SensorMotion sensor_motion = SensorMotion::AtRest);

  /** \brief Why the last cloud was left out, in one sentence. */
  SettingText
  leftOutMessage() const;

  RateControlStatus
  status() const;

private:
  bool
  isShort(bool is_i_frame) const;

  StepChoice choice_;
  LinkBudget budget_;
  CloudClock clock_;
  bool is_on_;
  double max_rate_;         // bits a second; 0: no limit
  Nanoseconds time_{0};     // never goes back
  Nanoseconds next_try_{0}; // of frames that are larger than the buffer
  std::size_t clouds_left_out_ = 0;
  std::size_t tried_bytes_ = 0; // of the last frame that had no room, until one has
};

} // namespace pcl_ext::PCL_EXT_ABI::io
