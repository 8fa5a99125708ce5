/** \file
 * \brief What a coder takes on the sampled room: time, memory, allocations.
 */
#pragma once

#include "coders/stream_coder.h"
#include "measuring/workload.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

namespace pcl_ext {
namespace measuring {

/** \brief I-frame periods before a stream is steady. The second I-frame is the first
 * one with a history, whose memory grows once more. */
constexpr std::size_t warm_up_periods = 2;

/** \brief I-frame periods of a stream, the warm-up among them, and frames of each. */
constexpr std::size_t growth_periods = 4;
constexpr unsigned int growth_i_frame_rate = 4;

/** \brief Frames of the sampled room; each I-frame period has the same ones. */
struct GrowthStream {
  Workload workload;
  std::size_t points = 0;               ///< of a frame
  std::size_t periods = growth_periods; ///< from one I-frame to the next
};

/** \brief What an encoder or a decoder takes of a stream. */
struct CallFigures {
  double milliseconds = 0.0; ///< a frame, median after the warm-up
  double megabytes = 0.0; ///< the most that was resident during calls, of these calls
  std::size_t allocations = 0; ///< most of a frame after the warm-up
};

/** \brief Figures of one coder. */
struct GrowthFigures {
  std::size_t voxels = 0; ///< that were decoded from the last frame
  std::size_t frames = 0; ///< that times are of
  CallFigures encode;
  CallFigures decode;
};

/** \brief Runs a coder in a process of its own, which has the clouds and nothing else.
 * \param[in] name of the coder, for messages
 * \throws std::runtime_error with the name if the coder fails, or if the last frame was
 * decoded to something else than was encoded
 */
GrowthFigures
measureCoder(const std::string& name,
             const std::function<std::unique_ptr<StreamCoder>()>& make_coder,
             const GrowthStream& stream);

} // namespace measuring
} // namespace pcl_ext
