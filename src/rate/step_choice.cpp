// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "rate/step_choice.h"

#include "rate/rate_texts.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Nanoseconds = StepChoice::Nanoseconds;

constexpr double load_after = 0.85;   // on a coarser step
constexpr double load_to_rise = 0.75; // on a better one

constexpr Nanoseconds patience = seconds(1);
constexpr Nanoseconds patience_without_room = milliseconds(300);
// After a change filters and history begin anew.
constexpr Nanoseconds settling = milliseconds(500);
constexpr double far_too_much = 1.5;
// Seconds over which max_rate is averaged to choose a step. For shorter, clouds are left
// out; a link that has dropped once does it again.
constexpr double seconds_falling = 1.0;
constexpr double seconds_rising = 5.0;
constexpr Nanoseconds shortest_hold = seconds(2);
constexpr Nanoseconds longest_hold = seconds(60);
constexpr Nanoseconds soon = seconds(10);
constexpr Nanoseconds trial_after = seconds(30);
constexpr unsigned int enough_frames = 5; // to judge a step by
// To learn from a change: the temporal filter has begun anew.
constexpr unsigned int settled_frames = 32;

/** \brief How much longer the next higher effort takes, at most. */
double
growthAbove(Effort effort)
{
  return effort == Effort::Fast ? 3.0 : 1.9;
}

Effort
next(Effort effort)
{
  return effort == Effort::Fast ? Effort::Balanced : Effort::Small;
}

} // namespace

StepChoice::StepChoice(const EncoderSettings& settings,
                       bool has_intensities,
                       bool can_remove_outliers,
                       const std::optional<float>& min_log_odds)
: base_(settings)
, settings_(settings)
, ladder_(settings, has_intensities, can_remove_outliers, min_log_odds)
, estimate_(settings)
, effective_(ladder_[0])
, max_rate_(settings.max_rate)
, mean_rate_(settings.max_rate)
, hold_(shortest_hold)
{}

void
StepChoice::advance(Nanoseconds elapsed, double max_rate)
{
  time_ += elapsed;
  const double passed = std::chrono::duration<double>(elapsed).count();
  if (max_rate < max_rate_)
    fall_a_second_ = (mean_rate_ - max_rate) / seconds_falling;
  max_rate_ = max_rate;
  // Falls all the way in that time, however low the rate is.
  if (mean_rate_ > max_rate)
    mean_rate_ = std::max(max_rate, mean_rate_ - passed * fall_a_second_);
  else
    mean_rate_ += (max_rate - mean_rate_) * (1.0 - std::exp(-passed / seconds_rising));
}

void
StepChoice::choose(bool is_short)
{
  followMotion();
  if (!keepEncodeTime())
    keepRate(is_short);
}

void
StepChoice::endFrame(const VoxelGrid& grid, SensorMotion sensor_motion)
{
  has_changed_ = false;
  too_large_ = 0;
  if (effective_.doublings == 0)
    finest_ = grid;
  if (change_ && estimate_.frames() >= settled_frames)
    learnFromChange();
  if (sensor_motion == SensorMotion::Moving)
    moved_at_ = time_;
  has_rested_ |= sensor_motion == SensorMotion::AtRest;
}

/** \brief Does without the temporal filter while the sensor moves, for a while after, and
 * until it is known to rest. */
void
StepChoice::followMotion()
{
  const bool is_idle = moved_at_ ? time_ - *moved_at_ < soon : !has_rested_;
  if (is_idle == ladder_.isFilterIdle())
    return;
  ladder_.setFilterIdle(is_idle);
  if (is_idle)
    return take(step_, "the sensor moves");
  std::size_t step = least_step_;
  while (step < step_ && !fits(step, load_after))
    ++step;
  if (step < step_)
    change(step, "the sensor rests");
  else
    take(step_, "the sensor rests");
}

void
StepChoice::describe(RateControlStatus& status) const
{
  status.encode_ms = estimate_.encodeMs();
  status.step = effective_;
  status.resolution = settings_.resolution;
  status.step_number = step_;
  status.last_step = ladder_.size() - 1;
  status.changes = changes_;
  status.choice = stepText(effective_, settings_.resolution);
  status.reason = reason_;
  status.not_kept =
      (rate_not_kept_.empty() ? "" : "clouds are left out, as ") + rate_not_kept_ +
      (rate_not_kept_.empty() || time_not_kept_.empty() ? "" : "; ") + time_not_kept_;
}

/** \brief Share of the rate that frames would take on a step. */
double
StepChoice::loadOf(std::size_t step) const
{
  return estimate_.bytesPerSecond(ladder_.ratios(step_, step)) * 8.0 / mean_rate_;
}

/** \brief Whether frames on a step take at most a share of the rate, and an I-frame of
 * the buffer. Where the next step has larger voxels, they may take more, as far as
 * clouds may be left out. */
bool
StepChoice::fits(std::size_t step, double share) const
{
  const bool is_last_of_edge = step + 1 == ladder_.size() ||
                               ladder_[step + 1].doublings > ladder_[step].doublings;
  const double most = is_last_of_edge ? share / base_.rate_sent_share : share;
  return loadOf(step) <= most &&
         estimate_.bytesOf(true) * ladder_.ratios(step_, step).i_frame <=
             share * bufferBytes();
}

/** \brief What the largest frame may take. */
double
StepChoice::bufferBytes() const
{
  return mean_rate_ / 8.0 * base_.rate_buffer;
}

bool
StepChoice::hasHeld() const
{
  return time_ - changed_at_ >= hold_ && estimate_.frames() >= enough_frames;
}

/** \brief Takes another step where frames take too long, or no longer do.
 * \return whether it did */
bool
StepChoice::keepEncodeTime()
{
  const double most = base_.max_encode_ms;
  const double mean = estimate_.encodeMs();
  if (most == 0.0 || estimate_.frames() < enough_frames)
    return false;
  const std::string reason =
      "frames took " + numberText(mean) + " ms of " + numberText(most) + " at most";
  time_not_kept_.clear();
  if (mean > most)
    return goDownInTime(reason);
  if (!hasHeld())
    return false;
  const Effort wanted = ladder_[step_].effort;
  if (effort_limit_ < wanted &&
      mean * growthAbove(effective_.effort) < load_to_rise * most) {
    effort_limit_ = next(effort_limit_);
    change(step_, reason);
    return true;
  }
  // Half the edge makes four times the voxels, at most.
  if (least_step_ == 0 || 4.0 * mean >= load_to_rise * most)
    return false;
  least_step_ = stepOfDoublings(ladder_[least_step_].doublings - 1);
  if (base_.max_rate > 0.0) {
    changed_at_ = time_;
    return false; // keepRate() goes up
  }
  change(least_step_, reason);
  return true;
}

bool
StepChoice::goDownInTime(const std::string& reason)
{
  if (base_.format == StreamFormat::Version1 && effective_.effort != Effort::Fast) {
    effort_limit_ =
        effective_.effort == Effort::Small ? Effort::Balanced : Effort::Fast;
    change(step_, reason);
    return true;
  }
  const std::size_t coarser = stepOfDoublings(effective_.doublings + 1);
  if (coarser < ladder_.size()) {
    least_step_ = coarser;
    change(std::max(step_, coarser), reason);
    return true;
  }
  time_not_kept_ = "the encode time is not kept: " + reason + " on the coarsest step";
  return false;
}

/** \brief First step with a number of doublings, or the end. */
std::size_t
StepChoice::stepOfDoublings(unsigned int doublings) const
{
  std::size_t step = 0;
  while (step < ladder_.size() && ladder_[step].doublings < doublings)
    ++step;
  return doublings == 0 ? 0 : step;
}

void
StepChoice::keepRate(bool is_short)
{
  if (base_.max_rate == 0.0 || estimate_.bytesOf(true) == 0.0)
    return;
  // No mean is waited for where a frame has shown that the step cannot be kept.
  const bool is_too_large = static_cast<double>(too_large_) > bufferBytes();
  if (!is_too_large && changes_ > 0 && time_ - changed_at_ < settling)
    return;
  const bool is_over = !fits(step_, most_rate_load);
  if (!is_over)
    over_since_.reset();
  else if (!over_since_)
    over_since_ = time_;
  if (is_over) {
    const Nanoseconds over = time_ - *over_since_;
    if (is_too_large || over >= patience ||
        (is_short && (over >= patience_without_room || !fits(step_, far_too_much))))
      goDown();
  }
  else if (hasHeld())
    goUp();
  rate_not_kept_.clear();
  if (loadOf(step_) > 1.0 || !fits(step_, 1.0))
    rate_not_kept_ = overload();
}

std::string
StepChoice::overload() const
{
  return overloadText(estimate_.bytesPerSecond(),
                      estimate_.bytesOf(true),
                      mean_rate_,
                      base_.rate_buffer);
}

void
StepChoice::goDown()
{
  std::size_t step = step_;
  while (step + 1 < ladder_.size() && !fits(step, load_after))
    ++step;
  if (step != step_)
    change(step, overload());
}

void
StepChoice::goUp()
{
  for (std::size_t step = least_step_; step < step_; ++step) {
    const bool is_next = step + 1 == step_;
    // A wrong share of what several steps save would be believed for ever.
    const bool is_tried =
        is_next && !ladder_.isMeasured(step_) && time_ - changed_at_ >= trial_after;
    if (!(fits(step, load_to_rise) && (is_next || ladder_.isLearned(step_, step))) &&
        !is_tried)
      continue;
    change(step,
           "frames took " + rateText(estimate_.bytesPerSecond() * 8.0) + " of " +
               rateText(mean_rate_) + " at most");
    return;
  }
}

void
StepChoice::change(std::size_t step, const std::string& reason)
{
  if (change_ && estimate_.frames() > 1)
    learnFromChange();
  const bool is_better =
      step < step_ || (step == step_ && effort_limit_ > effective_.effort);
  if (is_better)
    up_at_ = time_;
  else if (up_at_ && time_ - *up_at_ < soon)
    hold_ = std::min(2 * hold_, longest_hold);
  else
    hold_ = shortest_hold;
  change_.reset();
  if (step != step_)
    change_ = Change{step_, estimate_.bytesOf(true), estimate_.bytesOf(false)};
  estimate_.scale(ladder_.ratios(step_, step));
  changed_at_ = time_;
  over_since_.reset();
  too_large_ = 0;
  rate_not_kept_.clear();
  time_not_kept_.clear();
  take(step, reason);
}

/** \brief Sets the step, and what of it is in force. */
void
StepChoice::take(std::size_t step, const std::string& reason)
{
  const RateStep before = effective_;
  step_ = step;
  effective_ = ladder_.inForce(step);
  effective_.effort = std::min(effective_.effort, effort_limit_);
  if (effective_ == before)
    return;
  settings_ = settingsOf(effective_, base_, finest_);
  has_changed_ = true;
  ++changes_;
  reason_ = reason;
}

void
StepChoice::learnFromChange()
{
  if (change_->p_frame > 0.0)
    ladder_.learn(change_->from,
                  step_,
                  {estimate_.bytesOf(true) / change_->i_frame,
                   estimate_.bytesOf(false) / change_->p_frame});
  change_.reset();
}

} // namespace pcl_ext::PCL_EXT_ABI::io
