// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief A CentralNode under the load of many streams.
 */
#pragma once

#include "experiments/tables.h"
#include "measuring/workload.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace experiments {

using measuring::Variant;
using measuring::Workload;

/** \brief What options say of the sensors. */
Workload
workloadOf(const Options& options);

/** \brief An encoded stream that is sent repeatedly. */
struct SensorStream {
  std::vector<std::vector<std::uint8_t>> frames;
  std::vector<std::size_t> i_frames; ///< which frames are I-frames; the first one is
  std::size_t bytes = 0;             ///< of all frames
  std::size_t voxels = 0;            ///< of all frames
};

/** \brief Encodes the streams of the robot cell's six cameras as their SensorNodes do.
 * \param[in] frames of each
 * \throws std::runtime_error if a cloud cannot be encoded
 */
std::vector<SensorStream>
encodeCell(std::size_t frames, const Workload& workload, const Variant& variant);

/** \brief Number, rate and settings of the streams. */
struct StreamLoad {
  std::size_t streams = 1;
  unsigned int threads = 0;       ///< that decode; 0: one for each core
  double frames_per_second = 0.0; ///< of each stream; 0: as fast as they are decoded
  double seconds = 5.0;           ///< measured, after all streams have begun
  unsigned int i_frame_rate = 30; ///< of the streams
  double resolution = 0.04;       ///< of the streams, metres
  float min_intensity = 2.0f;     ///< voxels below it are removed
};

/** \brief Figures of the frames that were measured. */
struct LoadResult {
  std::size_t frames = 0;   ///< decoded
  std::size_t late = 0;     ///< of these: more than a period after they were due
  std::size_t lost = 0;     ///< failed or refused, of the whole run
  double seconds = 0.0;     ///< by the clock
  double cpu_seconds = 0.0; ///< of the whole process, the sending included
  double mean_latency_ms = 0.0;
  double max_latency_ms = 0.0;
  double megabytes_per_stream = 0.0; ///< growth of resident memory
  double merge_ms = 0.0;             ///< of the last frames of all streams
  std::size_t merged_voxels = 0;     ///< of these
};

/** \brief The most frames that a stream of a load sends. */
std::size_t
ticksOf(const StreamLoad& load);

/** \brief Decoders take a frame that comes again after fewer for an old one. */
constexpr std::size_t frames_to_repeat = 257;

/** \brief Sends streams to a new CentralNode.
 *
 * Stream n sends the frames of sources[n % sources.size()], which are frames_to_repeat or
 * as many as are sent, again and again. The streams
 * are spread evenly over the period, start at different I-frames of their source, and
 * have their I-frames at different times.
 * \param[in] sources at least one, each of at least one frame
 * \param[in] load above 0 streams
 */
LoadResult
sendStreams(const std::vector<SensorStream>& sources, const StreamLoad& load);

/** \brief The most streams of which a run had every frame decoded within its period.
 * \param[in] sources as above
 * \param[in] load its streams are the most to try; its rate is above 0
 * \param[out] best the run; no frames if there is none
 * \return 0 if there is none
 */
std::size_t
mostStreams(const std::vector<SensorStream>& sources,
            const StreamLoad& load,
            LoadResult& best);

} // namespace experiments
} // namespace pcl_ext
