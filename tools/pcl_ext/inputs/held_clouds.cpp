// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/held_clouds.h"

#include "console/interruption.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace pcl_ext::tools {

namespace {

/** \brief Times of the first and the last cloud that is held. */
struct Span {
  recording::Time first_stamp{0};
  recording::Time last_stamp{0};
  recording::Time first_message{0};
  recording::Time last_message{0};
};

double
periodOf(const Span& span, std::size_t clouds)
{
  const auto of_stamps = span.last_stamp - span.first_stamp;
  const auto of_messages = span.last_message - span.first_message;
  // Some drivers set no stamps.
  const auto duration = of_stamps.count() > 0 ? of_stamps : of_messages;
  return clouds < 2 || duration.count() <= 0
             ? 0.0
             : std::chrono::duration<double>(duration).count() /
                   static_cast<double>(clouds - 1);
}

void
hold(InputCloud& cloud, HeldClouds& stream, Span& span)
{
  if (stream.clouds.empty()) {
    span.first_stamp = cloud.stamp;
    span.first_message = cloud.message.log_time;
  }
  span.last_stamp = cloud.stamp;
  span.last_message = cloud.message.log_time;
  stream.clouds.push_back(std::exchange(cloud.cloud, {}));
}

} // namespace

std::vector<HeldClouds>
holdClouds(CloudInput& input, std::size_t clouds)
{
  using Clock = std::chrono::steady_clock;
  constexpr std::size_t most_bytes = std::size_t{1} << 28; // of all together
  constexpr std::chrono::seconds most_time{30};
  const Clock::time_point end = Clock::now() + most_time;
  std::vector<HeldClouds> streams(input.streams().size());
  std::vector<Span> spans(streams.size());
  std::size_t bytes = 0;
  InputCloud cloud;
  recording::McapMessage other;
  const auto is_full = [clouds](const HeldClouds& stream) {
    return stream.clouds.size() >= clouds;
  };
  while (bytes < most_bytes && Clock::now() < end && !isInterrupted() &&
         (streams.empty() || !std::all_of(streams.begin(), streams.end(), is_full))) {
    const CloudInput::Found found = input.next(cloud, other);
    if (found == CloudInput::Found::End)
      break;
    if (found != CloudInput::Found::Cloud)
      continue;
    streams.resize(input.streams().size()); // those of a pipe come one by one
    spans.resize(streams.size());
    HeldClouds& stream = streams[cloud.stream];
    if (!cloud.failure.empty())
      stream.failures.push_back(cloud.source + ": " + cloud.failure);
    else if (!is_full(stream)) {
      bytes += cloud.cloud.data.size();
      hold(cloud, stream, spans[cloud.stream]);
    }
  }
  for (std::size_t i = 0; i < streams.size(); ++i) {
    streams[i].name = input.streams()[i];
    streams[i].is_topic = input.isBag();
    streams[i].has_assumed_period = input.assumesTimes(i);
    streams[i].period = periodOf(spans[i], streams[i].clouds.size());
  }
  return streams;
}

} // namespace pcl_ext::tools
