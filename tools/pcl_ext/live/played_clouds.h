// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/i_frame_requests.h>

#include "console/exit_status.h"
#include "console/interruption.h"
#include "inputs/cloud_input.h"
#include "live/cloud_times.h"
#include "live/live_output.h"
#include "live/real_time.h"
#include "live/sender_figures.h"
#include "options/encoding_options.h"
#include "streams/frame_failures.h"
#include "streams/stream_encoder.h"

#include <array>
#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::tools {

/** \brief Encodes the clouds of files or of a bag at the pace of their times, and passes
 * the frames on. Clouds for which the machine is too slow are left out. */
class PlayedClouds {
public:
  /** \param[in] options must outlive this
   * \param[in] input must outlive this
   * \param[in] failures of clouds are printed by it
   */
  PlayedClouds(const EncodingOptions& options,
               CloudInput& input,
               FrameFailures& failures)
  : options_(options), input_(input), failures_(failures)
  {}

  /** \brief Makes the next frame of a stream of the output an I-frame, but not two in a
   * row. Called by any thread. */
  void
  requestIFrame(std::size_t stream)
  {
    figures_.addRequest(stream);
    if (stream < requests_.size())
      requests_[stream].add();
  }

  /** \brief Passes frames on until the input ends or the program is interrupted.
   * \param[in] meanwhile called about 20 times a second
   * \throws std::exception
   */
  void
  run(LiveOutput& output, const std::function<void()>& meanwhile)
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

  /** \brief Health of the streams, see SenderFigures::metrics(). Called by any thread. */
  std::string
  metrics(const std::string& prefix = "") const
  {
    return figures_.metrics(prefix);
  }

  std::size_t
  frames() const
  {
    return frames_;
  }

  /** \brief Clouds that could not be encoded. */
  std::size_t
  failedClouds() const
  {
    return failed_clouds_;
  }

  /** \brief Clouds that were left out, as the machine is too slow. */
  std::size_t
  lateClouds() const
  {
    return late_clouds_;
  }

  /** \brief Clouds that were left out, as the output took none for a while. */
  std::size_t
  blockedClouds() const
  {
    return blocked_clouds_;
  }

  /** \brief Clouds that were left out, as --max-rate had no room for them. */
  std::size_t
  cloudsWithoutRoom() const
  {
    std::size_t clouds = 0;
    for (const Stream& stream : streams_)
      clouds += stream.encoder.sums().clouds_left_out;
    return clouds;
  }

  /** \brief A sentence for each stream none of whose clouds had room. After run(). */
  std::vector<std::string>
  streamsWithoutRoom() const
  {
    std::vector<std::string> sentences;
    for (std::size_t i = 0; i < streams_.size(); ++i)
      if (const EncodedSums& sums = streams_[i].encoder.sums();
          sums.frames == 0 && sums.clouds_left_out > 0)
        sentences.push_back(
            describeNoRoom(input_.streams()[i], streams_[i].encoder.sums()));
    return sentences;
  }

  /** \brief What is to be known of points that are outside the grid of voxels, a sentence
   * for each stream that has some. After run(). */
  std::vector<std::string>
  pointsOutsideGrid() const
  {
    std::vector<std::string> sentences;
    for (const Stream& stream : streams_)
      if (stream.encoder.sums().points_outside_grid > 0)
        sentences.push_back(describePointsOutsideGrid(stream.encoder.sums()));
    return sentences;
  }

  /** \brief What is not encoded of the clouds, and what --max-rate has changed, see
   * StreamEncoder. After run(). */
  std::vector<std::string>
  remarks() const
  {
    std::vector<std::string> sentences;
    for (const Stream& stream : streams_)
      for (const auto& [about, sentence] : stream.encoder.remarks())
        if (about == Remark::LeftOut || about == Remark::Intensity ||
            about == Remark::Budget)
          sentences.push_back(sentence);
    return sentences;
  }

private:
  /** \brief Clouds that are later are left out. */
  static constexpr std::chrono::milliseconds most_late{500};

  struct Stream {
    Stream(const EncodingOptions& options, const std::string& name, bool is_topic)
    : encoder(options, name, is_topic)
    {}

    StreamEncoder encoder;
    bool has_law = false;              ///< a cloud with points came
    std::vector<InputCloud> waiting;   ///< those before it
    std::optional<std::size_t> number; ///< in the output, once there is a frame
    CloudTimes times;
  };

  /** \brief Encodes a cloud, but those of no points when the first one with points comes,
   * which tells the law of the stream. */
  void
  take(const InputCloud& cloud, LiveOutput& output)
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
  encodeWaiting(Stream& stream, LiveOutput& output)
  {
    for (const InputCloud& cloud : stream.waiting)
      encode(cloud, output);
    stream.waiting.clear();
  }

  void
  encode(const InputCloud& cloud, LiveOutput& output)
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
    output.publish(*stream.number,
                   stream.times.timeOf(cloud.stamp, cloud.message.log_time),
                   std::move(bytes));
    blocked_ += RealTime::Clock::now() - start;
    ++frames_;
  }

  const EncodingOptions& options_;
  CloudInput& input_;
  FrameFailures& failures_;
  std::deque<Stream> streams_; // those of the input
  static constexpr std::size_t most_requests = 4096;
  std::array<io::IFrameRequests, most_requests> requests_; // by number in the output
  SenderFigures figures_;
  std::size_t frames_ = 0;
  std::size_t failed_clouds_ = 0;
  std::size_t late_clouds_ = 0;
  std::size_t blocked_clouds_ = 0;
  std::chrono::nanoseconds blocked_{0}; // by the output, since clouds were in time
};

} // namespace pcl_ext::tools
