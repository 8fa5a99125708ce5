// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/nodes/impl/merge_schedule.h>

#include <algorithm>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

constexpr Time longest = std::chrono::hours(1);
constexpr Time shortest_period = std::chrono::milliseconds(1);
constexpr Time most_apart = std::chrono::seconds(2);
constexpr Time most_late = std::chrono::seconds(1);
constexpr Time least_set_back = std::chrono::seconds(1);
constexpr Time clock_window = std::chrono::seconds(2);
constexpr Time longest_decoding = std::chrono::seconds(2); // beside a period
constexpr Time longest_period = std::chrono::seconds(10);  // that memory is kept for
// As far as frames of a link; the least one so that differences do not overflow.
constexpr Time farthest_stamp{std::int64_t{1} << 62};
constexpr Time least_stamp{-(std::int64_t{1} << 61)};

std::string
milliseconds(Time time)
{
  return std::to_string(
             std::chrono::duration_cast<std::chrono::milliseconds>(time).count()) +
         " ms";
}

bool
areClose(Time a, Time b)
{
  return a - b <= most_apart && b - a <= most_apart;
}

} // namespace

std::string
faultOf(const MergeScheduleSettings& settings)
{
  if (settings.period < shortest_period || settings.period > longest)
    return "period is " + milliseconds(settings.period) + "; it must be 1 ms to 1 hour";
  if (settings.max_wait < Time(0) || settings.max_wait > longest)
    return "max_wait is " + milliseconds(settings.max_wait) +
           "; it must be 0 to 1 hour";
  if (settings.max_age < shortest_period || settings.max_age > longest)
    return "max_age is " + milliseconds(settings.max_age) +
           "; it must be 1 ms to 1 hour";
  return {};
}

MergeSchedule::MergeSchedule(const MergeScheduleSettings& settings)
: settings_(settings)
{}

bool
MergeSchedule::isAlive(const Stream& stream, Time now) const
{
  return now - stream.last_arrival <= settings_.max_age;
}

std::optional<Time>
MergeSchedule::commonOffset(Time now) const
{
  std::vector<Time> offsets;
  for (const auto& [name, stream] : streams_)
    if (isAlive(stream, now))
      offsets.push_back(stream.offset);
  if (offsets.empty())
    return std::nullopt;
  const auto middle =
      offsets.begin() + static_cast<std::ptrdiff_t>((offsets.size() - 1) / 2);
  std::nth_element(offsets.begin(), middle, offsets.end());
  return *middle;
}

Time
MergeSchedule::slotOf(Time stamp) const
{
  const Time past = stamp % settings_.period;
  if (past == Time(0))
    return stamp;
  return past > Time(0) ? stamp - past + settings_.period : stamp - past;
}

std::optional<Time>
MergeSchedule::earliestHeld(Time offset) const
{
  std::optional<Time> earliest;
  for (const auto& [name, stream] : streams_)
    if (areClose(stream.offset, offset))
      for (const HeldFrame& held : stream.held)
        earliest = std::min(earliest.value_or(held.frame.stamp), held.frame.stamp);
  return earliest;
}

void
MergeSchedule::endPause(Time now)
{
  const Time pause = now - last_arrival_.value_or(now);
  last_arrival_ = now;
  // A stream that has ended grows too old within a few pauses.
  if (pause > settings_.max_age)
    for (auto& [name, stream] : streams_)
      stream.last_arrival += pause - settings_.max_age / 2;
}

void
MergeSchedule::endClockWindow(Time now)
{
  if (clocks_since_ && now - *clocks_since_ < clock_window)
    return;
  clocks_since_ = now;
  for (auto& [name, stream] : streams_)
    stream.offset =
        std::exchange(stream.least_offset, std::nullopt).value_or(stream.offset);
}

void
MergeSchedule::judgeClock(Stream& stream, Time stamp, Time now, bool is_first)
{
  const Time offset = now - stamp;
  if (is_first || stream.last_stamp - stamp > least_set_back)
    stream.offset = stream.least_offset.emplace(offset);
  stream.offset = std::min(stream.offset, offset);
  stream.least_offset = std::min(stream.least_offset.value_or(offset), offset);
}

bool
MergeSchedule::add(ScheduledFrame frame, Time now)
{
  endPause(now);
  endClockWindow(now);
  Stream& stream = streams_[frame.stream];
  stream.last_arrival = now;
  frame.stamp = std::clamp(frame.stamp, least_stamp, farthest_stamp);
  const bool is_first = !stream.given_stamp;
  const bool is_new = std::exchange(stream.given_stamp, frame.stamp) != frame.stamp;
  if (!is_new)
    frame.stamp = now - stream.offset;
  judgeClock(stream, frame.stamp, now, is_first);
  stream.last_stamp = frame.stamp;
  stream.held.push_back({std::move(frame), now});
  return is_new;
}

std::vector<ScheduledFrame>
MergeSchedule::releaseAll()
{
  std::vector<ScheduledFrame> frames;
  for (auto& [name, stream] : streams_) {
    for (HeldFrame& held : stream.held)
      frames.push_back(std::move(held.frame));
    stream.held.clear();
    stream.released = 0;
  }
  is_late_ = false;
  has_more_since_.reset();
  beginAnew();
  return frames;
}

void
MergeSchedule::beginAnew()
{
  slot_.reset();
  has_frames_ = false;
  waiting_since_.reset();
  other_slots_.clear();
  ahead_ = Time(0);
}

void
MergeSchedule::countDecoded()
{
  for (auto& [name, stream] : streams_)
    stream.released = 0;
}

std::optional<Time>
MergeSchedule::newestStamp(Time offset, Time now) const
{
  std::optional<Time> newest;
  for (const auto& [name, stream] : streams_)
    if (isAlive(stream, now) && areClose(stream.offset, offset))
      newest = std::max(newest.value_or(stream.last_stamp), stream.last_stamp);
  return newest;
}

std::optional<Time>
MergeSchedule::latestOffset(Time offset, Time now) const
{
  const Stream* newest = nullptr;
  for (const auto& [name, stream] : streams_)
    if (isAlive(stream, now) && areClose(stream.offset, offset) &&
        (newest == nullptr || stream.last_stamp > newest->last_stamp))
      newest = &stream;
  if (newest == nullptr)
    return std::nullopt;
  return newest->last_arrival - newest->last_stamp;
}

bool
MergeSchedule::areClocksSetBack(Time offset, Time now)
{
  // After the newest frame there is at most one more slot than that which it is in.
  const Time farthest = 2 * settings_.period + settings_.max_wait;
  const auto newest = newestStamp(offset, now);
  if (newest && *slot_ - *newest <= farthest)
    ahead_ = Time(0);
  return newest && *slot_ - *newest - ahead_ > farthest;
}

Time
MergeSchedule::newestDue(Time offset, Time now) const
{
  const auto newest = newestStamp(offset, now);
  if (!newest)
    return Time::min();
  Time complete = *newest; // all streams have a frame then or later
  for (const auto& [name, stream] : streams_)
    if (isAlive(stream, now) && areClose(stream.offset, offset))
      complete = std::min(complete, stream.last_stamp);
  const Time due = std::max(complete, now - offset - settings_.max_wait);
  const Time later = slotOf(std::min(due, *newest));
  return later > due ? later - settings_.period : later;
}

bool
MergeSchedule::isLate(Time offset, Time now) const
{
  const Time wait = settings_.max_wait + most_late;
  return std::any_of(streams_.begin(), streams_.end(), [&](const auto& named) {
    const auto& held = named.second.held;
    if (held.empty() || !areClose(named.second.offset, offset))
      return false;
    // By its stamp, and since it arrived, as it may have come late.
    return now - offset - held.front().frame.stamp > wait &&
           now - held.front().arrival > wait;
  });
}

void
MergeSchedule::countLeftOut(Time offset, Time end)
{
  std::set<Time> left_out;
  if (has_frames_)
    left_out.insert(*slot_);
  for (const auto& [name, stream] : streams_)
    if (areClose(stream.offset, offset))
      for (const HeldFrame& held : stream.held)
        if (const Time slot = slotOf(held.frame.stamp); slot < end)
          left_out.insert(std::max(slot_.value_or(slot), slot));
  counts_.left_out += left_out.size();
}

void
MergeSchedule::leaveOutRest()
{
  countLeftOut(offset_, Time::max());
}

void
MergeSchedule::skipLate(Time offset, Time now)
{
  is_late_ |= isLate(offset, now);
  if (!is_late_)
    return;
  const Time newest = newestDue(offset, now);
  if (newest <= *slot_) {
    is_late_ = false;
    return;
  }
  countLeftOut(offset, newest);
  slot_ = newest;
  waiting_since_.reset();
}

bool
MergeSchedule::hasRoom(const Stream& stream, Time now) const
{
  return stream.released < settings_.max_released ||
         (settings_.skips_late && has_more_since_ &&
          now - *has_more_since_ >
              std::min(settings_.period, longest_period) + longest_decoding);
}

void
MergeSchedule::releaseFrames(Time offset, Time now, Step& step)
{
  const auto difference = latestOffset(offset, now);
  for (auto& [name, stream] : streams_) {
    const bool is_synchronous = areClose(stream.offset, offset);
    while (!stream.held.empty()) {
      HeldFrame& first = stream.held.front();
      const auto is_in_time = [&](const HeldFrame& held) {
        return held.frame.stamp <= *slot_;
      };
      // One that is followed by such a frame is of before its clock was set back.
      if (slot_ && is_synchronous && first.frame.stamp > *slot_ &&
          std::none_of(stream.held.begin(), stream.held.end(), is_in_time))
        break;
      // Nothing waits for those of another clock.
      if ((is_synchronous || !settings_.skips_late) && !hasRoom(stream, now)) {
        step.has_more = true;
        break;
      }
      if (slot_ && is_synchronous && first.frame.stamp == *slot_)
        waitSince(first.arrival);
      has_frames_ |= slot_ && is_synchronous;
      if (!is_synchronous && difference)
        other_slots_.insert(slotOf(first.arrival - *difference));
      step.frames.push_back(std::move(first.frame));
      stream.held.pop_front();
      ++stream.released;
    }
  }
  has_more_since_ =
      step.has_more ? std::optional(has_more_since_.value_or(now)) : std::nullopt;
}

void
MergeSchedule::waitSince(Time arrival)
{
  waiting_since_ = std::min(waiting_since_.value_or(arrival), arrival);
}

bool
MergeSchedule::isComplete(Time offset, Time now)
{
  if (has_ended_)
    return true;
  bool are_all_there = true;
  for (const auto& [name, stream] : streams_) {
    if (!isAlive(stream, now) || !areClose(stream.offset, offset))
      continue;
    if (stream.last_stamp < *slot_) {
      are_all_there = false;
      continue;
    }
    waitSince(stream.held.empty() ? stream.last_arrival : stream.held.front().arrival);
  }
  return are_all_there ||
         (waiting_since_ && now - *waiting_since_ >= settings_.max_wait);
}

bool
MergeSchedule::isDueForOthers(Time offset, Time now)
{
  const auto difference = latestOffset(offset, now);
  if (!difference || other_slots_.empty() || earliestHeld(offset))
    return false;
  const Time first = has_ended_ ? *other_slots_.rbegin() : *other_slots_.begin();
  const Time slot = has_frames_ ? *slot_ : std::max(*slot_, first);
  if (!has_ended_ && now - *difference < slot + settings_.max_wait)
    return false;
  ahead_ += slot - *slot_ + (has_frames_ ? Time(0) : settings_.period);
  slot_ = slot;
  has_frames_ = true;
  return true;
}

Time
MergeSchedule::oldestOf(Time merge, Time offset) const
{
  std::optional<Time> newest;
  for (const auto& [name, stream] : streams_)
    if (areClose(stream.offset, offset))
      newest = std::max(newest.value_or(stream.last_stamp), stream.last_stamp);
  return std::min(merge, newest.value_or(merge)) - settings_.max_age;
}

MergeSchedule::Step
MergeSchedule::next(Time now)
{
  Step step;
  // Without a stream that is alive what was held is merged as it is.
  const Time offset = offset_ = commonOffset(now).value_or(offset_);
  // What is released for a merged frame is merged.
  if (slot_ && settings_.skips_late && !has_more_since_)
    skipLate(offset, now);
  if (slot_ && areClocksSetBack(offset, now))
    beginAnew();
  if (!slot_)
    if (const auto earliest = earliestHeld(offset))
      slot_ = slotOf(*earliest);
  releaseFrames(offset, now, step);
  if (step.has_more || !slot_ ||
      (!isDueForOthers(offset, now) && !isComplete(offset, now)))
    return step;
  if (!has_frames_) {
    const auto earliest = earliestHeld(offset);
    if (!earliest)
      return step;             // nothing has arrived since the last merged frame
    slot_ = slotOf(*earliest); // nothing came for those between
    waiting_since_.reset();
    releaseFrames(offset, now, step);
    if (step.has_more || !isComplete(offset, now))
      return step;
  }
  step.merge = slot_;
  step.oldest = oldestOf(*slot_, offset);
  for (const auto& [name, stream] : streams_)
    if (isAlive(stream, now) && !areClose(stream.offset, offset))
      step.other_clocks.insert(name);
  ++counts_.made;
  other_slots_.erase(other_slots_.begin(), other_slots_.upper_bound(*slot_));
  slot_ = *slot_ + settings_.period;
  has_frames_ = false;
  waiting_since_.reset();
  return step;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
