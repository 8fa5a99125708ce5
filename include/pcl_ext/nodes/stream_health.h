#pragma once

#include <pcl_ext/compression/compression_status.h>
#include <pcl_ext/export.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace pcl_ext {
namespace nodes {

/** \brief A moment, as the time since the epoch of the clock that stamps the clouds. */
using Time = std::chrono::nanoseconds;

/** \brief Tells the time now. May be called by several threads at once. */
using Clock = std::function<Time()>;

/** \brief The clock of the machine, since 1970. */
PCL_EXT_EXPORT Time
systemTime();

/** \brief What went through a node in the seconds before now, as of one stream. */
struct StreamRates {
  /** \brief How far back the figures look. */
  static constexpr Time window = std::chrono::seconds(2);

  double frames_per_second =
      0.0; ///< from the spaces between frames; 0 for fewer than two
  double bytes_per_second = 0.0;   ///< of the coded frames
  double mean_cycle_seconds = 0.0; ///< computing for one frame
  double max_cycle_seconds = 0.0;
  /** \brief From a frame's stamp until it was ready; 0 of a frame that has none. */
  double mean_latency_seconds = 0.0;
  double max_latency_seconds = 0.0;
};

/** \brief How a stream that arrives at a CentralNode is doing. Counts are since it was
 * added. Every frame that was received is decoded, failed, dropped, refused, or still
 * waiting. */
struct StreamHealth {
  std::string name;
  std::size_t frames_received = 0; ///< handed to CentralNode::receive
  std::size_t frames_decoded = 0;
  std::size_t frames_failed = 0;  ///< arrived, but could not be decoded or denoised
  std::size_t frames_dropped = 0; ///< arrived late or twice; the stream went on
  std::size_t frames_refused = 0; ///< arrived while too many waited or memory ran out
  std::size_t frames_lost =
      0; ///< gaps in the sender's numbers that nothing arrived for in time
  std::size_t i_frame_requests = 0; ///< times that the listener was told wants_i_frame
  std::uint64_t bytes = 0;          ///< of all frames received
  std::size_t voxels = 0;           ///< of the last decoded frame, before denoising
  std::size_t kept_voxels = 0;      ///< of these: after denoising
  std::size_t outliers_removed = 0; ///< of `voxels`: by setOutlierRemoval()
  bool in_sync = false; ///< the last frame was decoded, even if it failed behind that
  Time last_decoded{0}; ///< when the last frame was ready; 0: never
  io::CompressionStatus last_failure; ///< why the last frame that failed did
  StreamRates rates;                  ///< of the frames that were decoded
};

} // namespace nodes
} // namespace pcl_ext
