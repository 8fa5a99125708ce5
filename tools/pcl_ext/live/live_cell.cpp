// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "live/live_cell.h"

#include "console/interruption.h"
#include "measuring/markdown_table.h"
#include "options/text_values.h"
#include "simulator/robot_cell.h"

#include <algorithm>
#include <limits>
#include <thread>
#include <utility>

namespace pcl_ext::tools {

namespace {

constexpr std::chrono::milliseconds poll_interval{20};
constexpr std::chrono::nanoseconds frame_period{
    static_cast<std::int64_t>(1e9 / cell::RobotCell::frame_rate)};

std::unique_ptr<clouds::CloudSequence>
openSensor(EncodingOptions& options, unsigned int number, std::uint32_t seed)
{
  auto sequence =
      clouds::openCell(number, std::numeric_limits<std::uint32_t>::max(), seed);
  options.setPose("/" + sequence->name(), WorldPose(sequence->sensorPose()));
  return sequence;
}

} // namespace

LiveCell::Sensor::Sensor(EncodingOptions& options,
                         unsigned int number,
                         std::uint32_t seed)
: sequence(openSensor(options, number, seed))
, name("/" + sequence->name())
, encoder(options, name)
{}

LiveCell::Clock::duration
LiveCell::Sensor::publish(std::uint32_t frame,
                          std::uint64_t start,
                          LiveOutput& output,
                          SenderFigures& figures)
{
  sequence->read(frame, cloud);
  cloud.header.stamp += start;
  if (requests.take())
    encoder.requestIFrame();
  std::vector<std::uint8_t> bytes;
  const std::chrono::microseconds time(cloud.header.stamp);
  const bool has_frame = encoder.encode(cloud, name, bytes, time);
  figures.addCloud(stream, encoder.statistics());
  if (!has_frame) // --max-rate had no room for it
    return Clock::duration(0);
  requests.countFrame();
  const Clock::time_point begin = Clock::now();
  output.publish(stream, time, std::move(bytes));
  return Clock::now() - begin;
}

LiveCell::LiveCell(EncodingOptions& options, unsigned int sensors, std::uint32_t seed)
: options_(options)
{
  options.completeForCell();
  options.check();
  for (unsigned int number = 1; number <= sensors; ++number)
    sensors_.push_back(std::make_unique<Sensor>(options, number, seed));
}

void
LiveCell::addStreams(LiveOutput& output)
{
  const IntensityLaw law = options_.law().value_or(automaticLaw(false));
  for (const auto& sensor : sensors_) {
    sensor->stream =
        output.addStream(sensor->name, options_.metadataOf(sensor->name, law, false));
    figures_.addStream(sensor->stream, sensor->name);
  }
}

void
LiveCell::runSensors(std::size_t first, std::size_t step, LiveOutput& output)
{
  std::uint32_t expected = 0; // the next frame; 0: any
  Clock::duration blocked{0}; // by the output, in the last frame
  while (!has_ended_) {
    if (!output.isWanted()) {
      expected = 0;
      std::this_thread::sleep_for(poll_interval);
      continue;
    }
    // The one of now, so that a slow machine leaves frames out.
    const auto frame =
        static_cast<std::uint32_t>((Clock::now() - start_) / frame_period);
    const auto excused = static_cast<std::uint32_t>(blocked / frame_period);
    const std::uint32_t left_out =
        expected > 0 && frame > expected + excused ? frame - expected - excused : 0;
    blocked = Clock::duration(0);
    expected = frame + 1;
    for (std::size_t i = first; i < sensors_.size() && !has_ended_; i += step) {
      count(*sensors_[i], left_out);
      blocked += sensors_[i]->publish(frame, start_stamp_, output, figures_);
    }
    std::this_thread::sleep_until(start_ + (frame + std::int64_t{1}) * frame_period);
  }
}

void
LiveCell::count(const Sensor& sensor, std::uint32_t clouds_left_out)
{
  ++clouds_;
  clouds_left_out_ += clouds_left_out;
  figures_.addMissed(sensor.stream, clouds_left_out);
}

std::size_t
LiveCell::cloudsWithoutRoom() const
{
  std::size_t clouds = 0;
  for (const auto& sensor : sensors_)
    clouds += sensor->encoder.sums().clouds_left_out;
  return clouds;
}

std::vector<std::string>
LiveCell::remarks() const
{
  std::vector<std::string> sentences;
  for (const auto& sensor : sensors_)
    for (const auto& [about, sentence] : sensor->encoder.remarks())
      if (about == Remark::Budget)
        sentences.push_back(sentence);
  return sentences;
}

std::string
LiveCell::overload() const
{
  const std::uint64_t clouds = clouds_;
  const std::uint64_t left_out = clouds_left_out_;
  if (left_out == 0)
    return {};
  const double rate = cell::RobotCell::frame_rate * static_cast<double>(clouds) /
                      static_cast<double>(clouds + left_out);
  return std::to_string(left_out) + " of " + counted(clouds + left_out, "cloud") +
         " left out, as this machine is too slow for them: " +
         measuring::formatted(rate, 1) + " a second of each sensor, not " +
         measuring::formatted(cell::RobotCell::frame_rate, 0) + "; take " +
         (options_.codec().effort == io::Effort::Fast ? "" : "a faster --effort, ") +
         "a larger --resolution, fewer sensors or a faster machine";
}

std::string
LiveCell::newOverload()
{
  constexpr std::chrono::seconds patience{5};
  if (is_overload_told_ || Clock::now() - start_ < patience)
    return {};
  const std::string text = overload();
  is_overload_told_ = !text.empty();
  return text;
}

void
LiveCell::startThreads(LiveOutput& output)
{
  const std::size_t count = std::min<std::size_t>(
      sensors_.size(), std::max(1u, std::thread::hardware_concurrency()));
  for (std::size_t i = 0; i < count; ++i)
    threads_.emplace_back([this, i, count, &output] {
      try {
        runSensors(i, count, output);
      }
      catch (...) {
        const std::lock_guard<std::mutex> lock(failure_mutex_);
        failure_ = std::current_exception();
        has_ended_ = true;
      }
    });
}

void
LiveCell::run(LiveOutput& output, const std::function<void()>& meanwhile)
{
  start_ = Clock::now();
  // At a multiple of the period, as if the sensors of all machines were triggered
  // together.
  const std::chrono::nanoseconds now =
      std::chrono::system_clock::now().time_since_epoch();
  start_stamp_ =
      static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(
                                     now / frame_period * frame_period)
                                     .count());
  try {
    startThreads(output);
    while (!has_ended_ && !isInterrupted()) {
      std::this_thread::sleep_for(poll_interval);
      if (meanwhile)
        meanwhile();
    }
  }
  catch (...) {
    failure_ = std::current_exception();
  }
  has_ended_ = true;
  for (std::thread& thread : threads_)
    thread.join();
  if (failure_)
    std::rethrow_exception(failure_);
}

} // namespace pcl_ext::tools
