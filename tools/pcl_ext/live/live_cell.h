// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/i_frame_requests.h>

#include "clouds/cloud_sequence.h"
#include "live/live_output.h"
#include "live/sender_figures.h"
#include "options/encoding_options.h"
#include "streams/stream_encoder.h"

#include <pcl/PCLPointCloud2.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace pcl_ext::tools {

/** \brief The sensors of the simulated robot cell, live: they are captured and encoded
 * at their rate, as long as somebody looks. */
class LiveCell {
public:
  /** \param[in] options of encoding; must outlive this. Crop box and sensor are the
   * cell's unless they are set; poses are added
   * \param[in] sensors their number, 1 to 6
   * \param[in] seed of the random errors
   */
  LiveCell(EncodingOptions& options, unsigned int sensors, std::uint32_t seed);

  /** \brief Makes the next frame of a stream an I-frame, but not two in a row. Called by
   * any thread. */
  void
  requestIFrame(std::size_t stream)
  {
    sensors_[stream]->requests.add();
    figures_.addRequest(stream);
  }

  /** \brief Health of the sensors' streams, see SenderFigures::metrics(). Called by any
   * thread. */
  std::string
  metrics(const std::string& prefix = "") const
  {
    return figures_.metrics(prefix);
  }

  void
  addStreams(LiveOutput& output);

  /** \brief Says how many clouds were left out, as the machine is too slow for them, and
   * how many a second that leaves; empty if none was. Called by any thread. */
  std::string
  overload() const;

  /** \brief Clouds that were left out, as --max-rate had no room for them. After run(). */
  std::size_t
  cloudsWithoutRoom() const;

  /** \brief What --max-rate has changed, a sentence for each sensor. After run(). */
  std::vector<std::string>
  remarks() const;

  /** \brief The same as overload() once in a run, after some seconds; else empty. Called
   * by the function that run() takes. */
  std::string
  newOverload();

  /** \brief Publishes frames until the program is interrupted. If the machine is too
   * slow frames are left out; those that are made are of their time. See overload().
   * \param[in] meanwhile called about 20 times a second; may be empty
   * \throws std::exception if a frame cannot be encoded
   */
  void
  run(LiveOutput& output, const std::function<void()>& meanwhile = {});

private:
  using Clock = std::chrono::steady_clock;

  struct Sensor {
    Sensor(EncodingOptions& options, unsigned int number, std::uint32_t seed);

    /** \return how long the output took */
    Clock::duration
    publish(std::uint32_t frame,
            std::uint64_t start,
            LiveOutput& output,
            SenderFigures& figures);

    std::unique_ptr<clouds::CloudSequence> sequence;
    std::string name; ///< of the stream
    StreamEncoder encoder;
    io::IFrameRequests requests;
    std::size_t stream = 0; ///< in the output
    pcl::PCLPointCloud2 cloud;
  };

  void
  startThreads(LiveOutput& output);

  void
  runSensors(std::size_t first, std::size_t step, LiveOutput& output);

  /** \brief Counts the clouds of a sensor before one that is captured. */
  void
  count(const Sensor& sensor, std::uint32_t clouds_left_out);

  const EncodingOptions& options_;
  SenderFigures figures_;
  std::vector<std::unique_ptr<Sensor>> sensors_;
  std::vector<std::thread> threads_;
  Clock::time_point start_;
  bool is_overload_told_ = false;
  std::uint64_t start_stamp_ = 0; ///< microseconds since 1970
  std::atomic<std::uint64_t> clouds_{0};
  std::atomic<std::uint64_t> clouds_left_out_{0};
  std::atomic<bool> has_ended_{false};
  std::mutex failure_mutex_;
  std::exception_ptr failure_;
};

} // namespace pcl_ext::tools
