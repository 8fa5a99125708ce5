#include <pcl_ext/compression/rate_control.h>

#include "rate/cloud_clock.h"
#include "rate/link_budget.h"
#include "rate/rate_estimate.h"
#include "rate/rate_ladder.h"
#include "rate/rate_texts.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace pcl_ext {
namespace io {

namespace {

using Nanoseconds = RateControl::Nanoseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr double most_load = 0.95;    // where a step is left for a coarser one
constexpr double load_after = 0.85;   // on that one
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

} // namespace

class RateControl::Implementation {
public:
  Implementation(const EncoderSettings& settings,
                 bool has_intensities,
                 bool can_remove_outliers,
                 const std::optional<float>& min_log_odds)
  : base_(settings)
  , settings_(settings)
  , ladder_(settings, has_intensities, can_remove_outliers, min_log_odds)
  , budget_(settings.rate_buffer)
  , estimate_(settings.i_frame_rate)
  , effective_(ladder_[0])
  {
    if (settings.max_rate > 0.0)
      budget_.setRate(settings.max_rate);
    mean_rate_ = settings.max_rate;
    status_.is_on = settings.max_rate > 0.0 || settings.max_encode_ms > 0.0;
    status_.max_rate = settings.max_rate;
    status_.reason = "at the start of the stream";
  }

  void
  setMaxRate(double bits_per_second)
  {
    if (status_.max_rate == 0.0 || !(bits_per_second > 0.0) ||
        bits_per_second == status_.max_rate)
      return;
    status_.max_rate = std::clamp(bits_per_second, least_max_rate, most_max_rate);
    budget_.setRate(status_.max_rate);
  }

  bool
  beginCloud(Nanoseconds time, bool is_i_frame_due)
  {
    const std::optional<Nanoseconds> interval = clock_.take(time);
    if (interval)
      estimate_.addInterval(*interval);
    const Nanoseconds elapsed = interval.value_or(Nanoseconds::zero());
    time_ += elapsed;
    budget_.advance(elapsed);
    followMaxRate(elapsed);
    if (!status_.is_on)
      return true;
    if (!keepEncodeTime())
      keepRate(isShort(is_i_frame_due));
    // What follows a change is an I-frame, as a rule.
    if (!isShort(is_i_frame_due || has_changed_))
      return true;
    ++status_.clouds_left_out;
    return false;
  }

  bool
  hasChanged() const
  {
    return has_changed_;
  }

  const EncoderSettings&
  settings() const
  {
    return settings_;
  }

  const std::optional<float>&
  minLogOdds() const
  {
    return effective_.min_log_odds;
  }

  bool
  endFrame(std::size_t bytes,
           bool is_i_frame,
           Nanoseconds encode_time,
           const VoxelGrid& grid)
  {
    has_changed_ = false;
    if (!status_.is_on)
      return true;
    if (effective_.doublings == 0)
      finest_ = grid;
    // One that was tried: the scene is another, for frames of both kinds.
    const double expected = estimate_.bytesOf(is_i_frame);
    if (status_.max_rate > 0.0 && budget_.isEmpty() &&
        expected > static_cast<double>(budget_.room()) && bytes <= budget_.room()) {
      const double ratio = static_cast<double>(bytes) / expected;
      estimate_.expectMultiple({ratio, ratio});
    }
    estimate_.addFrame(bytes, is_i_frame, encode_time);
    if (change_ && estimate_.frames() >= settled_frames)
      learnFromChange();
    if (status_.max_rate == 0.0)
      return true;
    if (bytes > budget_.room()) {
      if (budget_.isEmpty())
        next_try_ = time_ + LinkBudget::window;
      ++status_.clouds_left_out;
      return false;
    }
    budget_.add(bytes);
    return true;
  }

  std::string
  leftOutMessage() const
  {
    return "the cloud was left out, as max_rate of " + rateText(status_.max_rate) +
           " has room for " + std::to_string(budget_.room()) + " bytes now" +
           (rate_not_kept_.empty() ? "" : "; " + rate_not_kept_);
  }

  RateControlStatus
  status() const
  {
    RateControlStatus status = status_;
    status.used_rate = status.max_rate * budget_.load();
    status.encode_ms = estimate_.encodeMs();
    status.step = effective_;
    status.resolution = settings_.resolution;
    status.step_number = step_;
    status.last_step = ladder_.size() - 1;
    status.choice = stepText(effective_, settings_.resolution);
    status.not_kept = rate_not_kept_ +
                      (rate_not_kept_.empty() || time_not_kept_.empty() ? "" : "; ") +
                      time_not_kept_;
    return status;
  }

private:
  void
  followMaxRate(Nanoseconds elapsed)
  {
    const double passed = std::chrono::duration<double>(elapsed).count();
    const double over =
        status_.max_rate < mean_rate_ ? seconds_falling : seconds_rising;
    mean_rate_ += (status_.max_rate - mean_rate_) * (1.0 - std::exp(-passed / over));
  }

  struct Change {
    std::size_t from = 0;
    double i_frame = 0.0; // bytes before
    double p_frame = 0.0;
  };

  /** \brief Whether there is no room for what the next frame is expected to be. Where the
   * buffer is empty it is tried once a second, as frames may have become smaller. */
  bool
  isShort(bool is_i_frame) const
  {
    if (status_.max_rate == 0.0)
      return false;
    if (budget_.isEmpty())
      return time_ < next_try_;
    // Where clouds are left out in any case, those that are sent need not wait, too.
    if (loadOf(step_) > 1.0 && budget_.backlog() > estimate_.interval())
      return true;
    return estimate_.bytesOf(is_i_frame) > static_cast<double>(budget_.room());
  }

  /** \brief Share of the rate that frames would take on a step. */
  double
  loadOf(std::size_t step) const
  {
    return estimate_.bytesPerSecond(ladder_.ratios(step_, step)) * 8.0 / mean_rate_;
  }

  /** \brief Whether frames on a step take at most a share of the rate, and an I-frame of
   * the buffer. Where the next step has larger voxels, they may take more, as far as
   * clouds may be left out. */
  bool
  fits(std::size_t step, double share) const
  {
    const bool is_last_of_edge = step + 1 == ladder_.size() ||
                                 ladder_[step + 1].doublings > ladder_[step].doublings;
    const double most = is_last_of_edge ? share / base_.rate_sent_share : share;
    return loadOf(step) <= most &&
           estimate_.bytesOf(true) * ladder_.ratios(step_, step).i_frame <=
               share * mean_rate_ / 8.0 * base_.rate_buffer;
  }

  bool
  hasHeld() const
  {
    return time_ - changed_at_ >= hold_ && estimate_.frames() >= enough_frames;
  }

  /** \brief Takes another step where frames take too long, or no longer do.
   * \return whether it did */
  bool
  keepEncodeTime()
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
    if (status_.max_rate > 0.0) {
      changed_at_ = time_;
      return false; // keepRate() goes up
    }
    change(least_step_, reason);
    return true;
  }

  bool
  goDownInTime(const std::string& reason)
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
    time_not_kept_ = "max_encode_ms is not kept: " + reason + " on the coarsest step";
    return false;
  }

  /** \brief First step with a number of doublings, or the end. */
  std::size_t
  stepOfDoublings(unsigned int doublings) const
  {
    std::size_t step = 0;
    while (step < ladder_.size() && ladder_[step].doublings < doublings)
      ++step;
    return doublings == 0 ? 0 : step;
  }

  static Effort
  next(Effort effort)
  {
    return effort == Effort::Fast ? Effort::Balanced : Effort::Small;
  }

  void
  keepRate(bool is_short)
  {
    if (status_.max_rate == 0.0 || estimate_.bytesOf(true) == 0.0)
      return;
    if (status_.changes > 0 && time_ - changed_at_ < settling)
      return;
    const bool is_over = !fits(step_, most_load);
    if (!is_over)
      over_since_.reset();
    else if (!over_since_)
      over_since_ = time_;
    if (is_over) {
      const Nanoseconds over = time_ - *over_since_;
      if (over >= patience ||
          (is_short && (over >= patience_without_room || !fits(step_, far_too_much))))
        goDown();
    }
    else if (hasHeld())
      goUp();
    rate_not_kept_.clear();
    if (loadOf(step_) > 1.0 || !fits(step_, 1.0))
      rate_not_kept_ = "clouds are left out, as " + overload();
  }

  std::string
  overload() const
  {
    return overloadText(estimate_.bytesPerSecond(),
                        estimate_.bytesOf(true),
                        mean_rate_,
                        base_.rate_buffer);
  }

  void
  goDown()
  {
    std::size_t step = step_;
    while (step + 1 < ladder_.size() && !fits(step, load_after))
      ++step;
    if (step != step_)
      change(step, overload());
  }

  void
  goUp()
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
  change(std::size_t step, const std::string& reason)
  {
    if (change_ && estimate_.frames() > 1)
      learnFromChange();
    const RateStep before = effective_;
    const bool is_better =
        step < step_ || (step == step_ && effort_limit_ > before.effort);
    effective_ = ladder_[step];
    effective_.effort = std::min(effective_.effort, effort_limit_);
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
    step_ = step;
    changed_at_ = time_;
    over_since_.reset();
    rate_not_kept_.clear();
    time_not_kept_.clear();
    if (effective_ == before)
      return;
    settings_ = settingsOf(effective_, base_, finest_);
    has_changed_ = true;
    ++status_.changes;
    status_.reason = reason;
  }

  void
  learnFromChange()
  {
    if (change_->p_frame > 0.0)
      ladder_.learn(change_->from,
                    step_,
                    {estimate_.bytesOf(true) / change_->i_frame,
                     estimate_.bytesOf(false) / change_->p_frame});
    change_.reset();
  }

  EncoderSettings base_;
  EncoderSettings settings_; // of the step
  RateLadder ladder_;
  LinkBudget budget_;
  RateEstimate estimate_;
  RateStep effective_; // the step, with an effort that time allows
  std::size_t step_ = 0;
  std::size_t least_step_ = 0; // that time allows
  Effort effort_limit_ = Effort::Small;
  std::optional<VoxelGrid> finest_;
  CloudClock clock_;
  Nanoseconds time_{0};    // never goes back
  double mean_rate_ = 0.0; // bits a second
  Nanoseconds changed_at_{0};
  std::optional<Nanoseconds> up_at_;      // the last change to a better step
  Nanoseconds next_try_{0};               // of frames that are larger than the buffer
  std::optional<Nanoseconds> over_since_; // too much for the step
  Nanoseconds hold_ = shortest_hold;
  std::optional<Change> change_; // not learned from yet
  bool has_changed_ = false;     // since the last frame
  std::string rate_not_kept_;
  std::string time_not_kept_;
  RateControlStatus status_; // without what status() adds
};

RateControl::Nanoseconds
RateControl::timeOfStamp(std::uint64_t stamp)
{
  using std::chrono::microseconds;
  constexpr auto latest = std::chrono::duration_cast<microseconds>(Nanoseconds::max());
  return microseconds(std::min(stamp, static_cast<std::uint64_t>(latest.count())));
}

RateControl::RateControl(const EncoderSettings& settings,
                         bool has_intensities,
                         bool can_remove_outliers,
                         const std::optional<float>& min_log_odds)
: implementation_(std::make_unique<Implementation>(
      settings, has_intensities, can_remove_outliers, min_log_odds))
{}

RateControl::~RateControl() = default;
RateControl::RateControl(RateControl&&) noexcept = default;
RateControl&
RateControl::operator=(RateControl&&) noexcept = default;

void
RateControl::setMaxRate(double bits_per_second)
{
  implementation_->setMaxRate(bits_per_second);
}

bool
RateControl::beginCloud(Nanoseconds time, bool is_i_frame_due)
{
  return implementation_->beginCloud(time, is_i_frame_due);
}

bool
RateControl::hasChanged() const
{
  return implementation_->hasChanged();
}

const EncoderSettings&
RateControl::settings() const
{
  return implementation_->settings();
}

const std::optional<float>&
RateControl::minLogOdds() const
{
  return implementation_->minLogOdds();
}

bool
RateControl::endFrame(std::size_t bytes,
                      bool is_i_frame,
                      Nanoseconds encode_time,
                      const VoxelGrid& grid)
{
  return implementation_->endFrame(bytes, is_i_frame, encode_time, grid);
}

std::string
RateControl::leftOutMessage() const
{
  return implementation_->leftOutMessage();
}

RateControlStatus
RateControl::status() const
{
  return implementation_->status();
}

} // namespace io
} // namespace pcl_ext
