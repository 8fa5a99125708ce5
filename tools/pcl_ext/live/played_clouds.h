// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/i_frame_requests.h>

#include "inputs/cloud_input.h"
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
#include <string>
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
  requestIFrame(std::size_t stream);

  /** \brief Passes frames on until the input ends or the program is interrupted.
   * \param[in] meanwhile called about 20 times a second
   * \throws std::exception
   */
  void
  run(LiveOutput& output, const std::function<void()>& meanwhile);

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
  cloudsWithoutRoom() const;

  /** \brief A sentence for each stream none of whose clouds had room. After run(). */
  std::vector<std::string>
  streamsWithoutRoom() const;

  /** \brief What is to be known of points that are outside the grid of voxels, a sentence
   * for each stream that has some. After run(). */
  std::vector<std::string>
  pointsOutsideGrid() const;

  /** \brief What is not encoded of the clouds, and what --max-rate has changed, see
   * StreamEncoder. After run(). */
  std::vector<std::string>
  remarks() const;

private:
  struct Stream {
    Stream(const EncodingOptions& options, const std::string& name, bool is_topic)
    : encoder(options, name, is_topic)
    {}

    StreamEncoder encoder;
    bool has_law = false;              ///< a cloud with points came
    std::vector<InputCloud> waiting;   ///< those before it
    std::optional<std::size_t> number; ///< in the output, once there is a frame
  };

  void
  take(const InputCloud& cloud, LiveOutput& output);

  void
  encodeWaiting(Stream& stream, LiveOutput& output);

  void
  encode(const InputCloud& cloud, LiveOutput& output);

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
