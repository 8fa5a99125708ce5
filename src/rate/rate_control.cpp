// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "rate/rate_control.h"

#include "rate/rate_texts.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::io {

RateControl::RateControl(const EncoderSettings& settings,
                         bool has_intensities,
                         bool can_remove_outliers,
                         const std::optional<float>& min_log_odds)
: choice_(settings, has_intensities, can_remove_outliers, min_log_odds)
, budget_(settings.rate_buffer)
, is_on_(settings.max_rate > 0.0 || settings.max_encode_ms > 0.0)
, max_rate_(settings.max_rate)
{
  if (max_rate_ > 0.0)
    budget_.setRate(max_rate_);
}

void
RateControl::setMaxRate(double bits_per_second)
{
  if (max_rate_ == 0.0 || !(bits_per_second > 0.0) || bits_per_second == max_rate_)
    return;
  max_rate_ = std::clamp(bits_per_second, least_max_rate, most_max_rate);
  budget_.setRate(max_rate_);
}

bool
RateControl::beginCloud(Nanoseconds time, bool is_i_frame_due)
{
  const std::optional<Nanoseconds> interval = clock_.take(time);
  if (interval)
    choice_.estimate().addInterval(*interval);
  const Nanoseconds elapsed = interval.value_or(Nanoseconds::zero());
  time_ += elapsed;
  budget_.advance(elapsed);
  choice_.advance(elapsed, max_rate_);
  if (!is_on_)
    return true;
  choice_.choose(isShort(is_i_frame_due));
  // What follows a change is an I-frame, as a rule.
  if (!isShort(is_i_frame_due || choice_.hasChanged()))
    return true;
  ++clouds_left_out_;
  return false;
}

bool
RateControl::endFrame(std::size_t bytes,
                      bool is_i_frame,
                      Nanoseconds encode_time,
                      const VoxelGrid& grid,
                      SensorMotion sensor_motion)
{
  if (!is_on_)
    return true;
  RateEstimate& estimate = choice_.estimate();
  // One that was tried: the scene is another, for frames of both kinds.
  const double expected = estimate.bytesOf(is_i_frame);
  if (max_rate_ > 0.0 && budget_.isEmpty() &&
      expected > static_cast<double>(budget_.room()) && bytes <= budget_.room()) {
    const double ratio = static_cast<double>(bytes) / expected;
    estimate.expectMultiple({ratio, ratio});
  }
  estimate.addFrame(bytes, is_i_frame, encode_time);
  choice_.endFrame(grid, sensor_motion);
  if (max_rate_ == 0.0)
    return true;
  if (bytes > budget_.room()) {
    if (budget_.isEmpty()) {
      next_try_ = time_ + LinkBudget::window;
      const double least = static_cast<double>(bytes) / estimate.bytesOf(is_i_frame);
      if (least > 1.0)
        estimate.expectMultiple({least, least});
      choice_.setTooLarge(bytes);
    }
    ++clouds_left_out_;
    tried_bytes_ = bytes;
    return false;
  }
  tried_bytes_ = 0;
  budget_.add(bytes);
  return true;
}

SettingText
RateControl::leftOutMessage() const
{
  const std::string& reason = choice_.rateNotKept();
  return {"the cloud was left out, as {max_rate} of " + rateText(max_rate_) +
          " has room for " + std::to_string(budget_.room()) + " bytes now" +
          (tried_bytes_ > 0
               ? ", the last frame that was tried takes " + std::to_string(tried_bytes_)
               : "") +
          (reason.empty() ? "" : "; " + reason)};
}

RateControlStatus
RateControl::status() const
{
  RateControlStatus status;
  status.is_on = is_on_;
  status.max_rate = max_rate_;
  status.used_rate = max_rate_ * budget_.load();
  status.clouds_left_out = clouds_left_out_;
  choice_.describe(status);
  return status;
}

/** \brief Whether there is no room for what the next frame is expected to be. Where the
 * buffer is empty it is tried: on a new step at once, else once a second, as frames may
 * have become smaller. So is the first P-frame, of which nothing is known. */
bool
RateControl::isShort(bool is_i_frame) const
{
  if (max_rate_ == 0.0)
    return false;
  if (budget_.isEmpty())
    return time_ < next_try_ && !choice_.hasChanged();
  const RateEstimate& estimate = choice_.estimate();
  if (!is_i_frame && !estimate.knowsPFrames())
    return false;
  // Where clouds are left out in any case, those that are sent need not wait, too.
  if (choice_.load() > 1.0 && budget_.backlog() > estimate.interval())
    return true;
  return estimate.bytesOf(is_i_frame) > static_cast<double>(budget_.room());
}

} // namespace pcl_ext::PCL_EXT_ABI::io
