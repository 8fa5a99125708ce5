// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "live/played_clouds.h"

#include "console/exit_status.h"
#include "console/interruption.h"

#include <stdexcept>
#include <utility>

namespace pcl_ext::tools {

namespace {

/** \brief Clouds that are later are left out. */
constexpr std::chrono::milliseconds most_late{500};

} // namespace

void
PlayedClouds::requestIFrame(std::size_t stream)
{
  figures_.addRequest(stream);
  if (stream < requests_.size())
    requests_[stream].add();
}

void
PlayedClouds::run(LiveOutput& output, const std::function<void()>& meanwhile)
{
  RealTime pace;
  InputCloud cloud;
  recording::McapMessage other;
  while (!isInterrupted()) {
    const CloudInput::Found found = input_.next(cloud, other);
    if (found == CloudInput::Found::End)
      break;
    if (found != CloudInput::Found::Cloud)
      continue;
    const std::vector<std::string>& names = input_.streams();
    while (streams_.size() < names.size())
      streams_.emplace_back(options_, names[streams_.size()], input_.isBag());
    const std::chrono::nanoseconds late =
        pace.waitFor(cloud.message.log_time, meanwhile);
    if (late == std::chrono::nanoseconds(0))
      blocked_ = late;
    if (late > most_late) {
      ++(late - blocked_ > most_late ? late_clouds_ : blocked_clouds_);
      if (const auto number = streams_[cloud.stream].number)
        figures_.addMissed(*number, 1);
    }
    else if (!isInterrupted())
      take(cloud, output);
  }
  for (Stream& stream : streams_)
    encodeWaiting(stream, output);
  failures_.finish();
  output.end();
}

std::vector<std::string>
PlayedClouds::pointsOutsideGrid() const
{
  std::vector<std::string> sentences;
  for (const Stream& stream : streams_)
    if (stream.encoder.sums().points_outside_grid > 0)
      sentences.push_back(describePointsOutsideGrid(stream.encoder.sums()));
  return sentences;
}

std::size_t
PlayedClouds::cloudsWithoutRoom() const
{
  std::size_t clouds = 0;
  for (const Stream& stream : streams_)
    clouds += stream.encoder.sums().clouds_left_out;
  return clouds;
}

std::vector<std::string>
PlayedClouds::streamsWithoutRoom() const
{
  std::vector<std::string> sentences;
  for (std::size_t i = 0; i < streams_.size(); ++i)
    if (const EncodedSums& sums = streams_[i].encoder.sums();
        sums.frames == 0 && sums.clouds_left_out > 0)
      sentences.push_back(
          describeNoRoom(input_.streams()[i], streams_[i].encoder.sums()));
  return sentences;
}

std::vector<std::string>
PlayedClouds::remarks() const
{
  std::vector<std::string> sentences;
  for (const Stream& stream : streams_)
    for (const auto& [about, sentence] : stream.encoder.remarks())
      if (about == Remark::LeftOut || about == Remark::Intensity ||
          about == Remark::Budget)
        sentences.push_back(sentence);
  return sentences;
}

/** \brief Encodes a cloud, but those of no points when the first one with points comes,
 * which tells the law of the stream. */
void
PlayedClouds::take(const InputCloud& cloud, LiveOutput& output)
{
  Stream& stream = streams_[cloud.stream];
  if (cloud.failure.empty() && !stream.has_law) {
    if (!hasPoints(cloud.cloud)) {
      stream.waiting.push_back(cloud);
      return;
    }
    stream.encoder.chooseLaw(cloud.cloud);
    stream.has_law = true;
    encodeWaiting(stream, output);
  }
  encode(cloud, output);
}

void
PlayedClouds::encodeWaiting(Stream& stream, LiveOutput& output)
{
  for (const InputCloud& cloud : stream.waiting)
    encode(cloud, output);
  stream.waiting.clear();
}

void
PlayedClouds::encode(const InputCloud& cloud, LiveOutput& output)
{
  Stream& stream = streams_[cloud.stream];
  std::string failure = cloud.failure;
  std::vector<std::uint8_t> bytes;
  if (failure.empty())
    try {
      if (stream.number && *stream.number < requests_.size() &&
          requests_[*stream.number].take())
        stream.encoder.requestIFrame();
      if (!stream.encoder.encode(
              cloud.cloud, cloud.source, bytes, cloud.message.log_time)) {
        if (stream.number)
          figures_.addCloud(*stream.number, stream.encoder.statistics());
        return;
      }
    }
    catch (const UsageError&) {
      throw;
    }
    catch (const std::runtime_error& error) {
      failure = error.what();
    }
  if (!failure.empty()) {
    failures_.add(input_.streams()[cloud.stream], cloud.number, "", failure);
    ++failed_clouds_;
    return;
  }
  const std::string& name = input_.streams()[cloud.stream];
  if (!stream.number) {
    stream.number = output.addStream(
        name,
        options_.metadataOf(name, stream.encoder.law(), stream.encoder.isOfLidar()));
    figures_.addStream(*stream.number, name);
    for (std::size_t i = 0; i < stream.encoder.sums().clouds_left_out; ++i)
      figures_.addCloud(*stream.number, stream.encoder.statistics());
  }
  if (*stream.number < requests_.size())
    requests_[*stream.number].countFrame();
  figures_.addCloud(*stream.number, stream.encoder.statistics());
  const auto start = RealTime::Clock::now();
  output.publish(*stream.number, cloud.message.log_time, std::move(bytes));
  blocked_ += RealTime::Clock::now() - start;
  ++frames_;
}

} // namespace pcl_ext::tools
