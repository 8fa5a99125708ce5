// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "measured_sender.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace shown {

namespace {

nodes::Time
inNanoseconds(double seconds)
{
  return nodes::Time(std::llround(seconds * 1e9));
}

} // namespace

MeasuredSender::MeasuredSender(std::string name,
                               const nodes::SensorNodeSettings& settings,
                               const RateTrace& trace,
                               QualityJudge& judge)
: name_(std::move(name))
, has_budget_(settings.compression.max_rate > 0.0)
, trace_(trace)
, link_(trace)
, judge_(judge)
{
  nodes::SensorNodeSettings timed = settings;
  timed.clock = [this] { return inNanoseconds(time_); };
  node_ = std::make_unique<nodes::SensorNode>(timed);
  if (!node_->settingsStatus().ok())
    throw std::invalid_argument(node_->settingsStatus().message());
}

bool
MeasuredSender::encode(const pcl::PCLPointCloud2& cloud,
                       const WorldPose& pose,
                       double time,
                       std::vector<std::uint8_t>& bytes)
{
  time_ = time;
  if (has_budget_)
    node_->setMaxRate(trace_.at(last_rate_time_));
  const double rate = trace_.at(last_rate_time_);
  last_rate_time_ = time;
  nodes::SensorNodeStatus status;
  encode_ms.add(measuring::timeOf([&] { status = node_->encode(cloud, pose, bytes); }));
  if (!status.hasFrame() && status.code() != nodes::SensorNodeCode::LeftOut)
    throw std::runtime_error(status.message());
  if (!status.hasFrame())
    return false;
  if (!has_budget_ && link_.waitAt(time) > buffer_seconds) {
    node_->requestIFrame();
    return false;
  }
  const nodes::Time now = inNanoseconds(time);
  while (!loads_.empty() && loads_.front().first <= now - std::chrono::seconds(1))
    loads_.pop_front();
  loads_.emplace_back(now, 8.0 * static_cast<double>(bytes.size()) / rate);
  double load = 0.0;
  for (const auto& [sent, share] : loads_)
    load += share;
  largest_load = std::max(largest_load, load);
  return true;
}

void
MeasuredSender::send(const pcl::PCLPointCloud2& cloud,
                     const WorldPose& pose,
                     double time,
                     double next_time)
{
  Frame frame{time, 0.0, {}};
  if (encode(cloud, pose, time, frame.bytes)) {
    frame.arrival = link_.send(time, frame.bytes.size());
    frame_bytes.add(static_cast<double>(frame.bytes.size()));
    frames_.push_back(std::move(frame));
  }
  else
    ++clouds_left_out;
  receive(next_time);
  if (clouds_++ < first_judged)
    return;
  const ShownQuality quality = judge_.judge(shown_);
  surface_percent.add(quality.surface_percent);
  noise_percent.add(quality.noise_percent);
  if (quality.person_percent)
    person_percent.add(*quality.person_percent);
}

void
MeasuredSender::receive(double time)
{
  for (; !frames_.empty() && frames_.front().arrival <= time; frames_.pop_front()) {
    const Frame& frame = frames_.front();
    arrival_ages.add(frame.arrival - frame.time);
    bool is_decoded = false;
    decode_ms.add(measuring::timeOf([&] {
      is_decoded =
          decoder_.decode(frame.bytes.data(), frame.bytes.size(), received_).ok();
    }));
    if (is_decoded)
      std::swap(received_, shown_);
  }
}

} // namespace shown
} // namespace pcl_ext
