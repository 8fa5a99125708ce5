/** \file
 * \brief Measures what a sensor's node makes of its stream, frame by frame: the paper's
 * sections 3.1 and 3.2.
 */
#pragma once

#include <pcl_ext/nodes/sensor_node.h>

#include "measuring/result_file.h"
#include "measuring/workload.h"

#include <vector>

namespace pcl_ext {
namespace report {

/** \brief A way to code a stream, and the name that its results get. */
struct StreamCoder {
  measuring::Subject subject;
  nodes::SensorNodeSettings settings;
};

/** \brief Sends every cloud of a stream through a SensorNode and a decoder for each
 * coder.
 *
 * Quantities: voxels, bytes, bytes_per_voxel, ratio (16 bytes for each cropped point
 * against the bytes), megabits_per_second, encode_ms (cloud to bytes, preprocessing
 * included) and decode_ms (bytes to voxels), processor time both.
 * \param[in] stream clouds, read once for all coders
 * \param[in] frame_rate Hz
 * \throws std::runtime_error if a frame cannot be coded, or its decoded voxels differ
 * in number
 */
void
measureCoders(const measuring::InputStream& stream,
              double frame_rate,
              const std::vector<StreamCoder>& coders,
              measuring::ResultFile& results);

/** \brief Moves and crops every cloud of a stream.
 *
 * Quantities: cloud_points (all, also without a return), points (with a return),
 * cropped_points, cropping_ratio (of cloud_points to cropped_points), kept_percent (of
 * points) and preprocess_ms.
 */
void
measureCropping(const measuring::InputStream& stream,
                const measuring::Subject& subject,
                measuring::ResultFile& results);

} // namespace report
} // namespace pcl_ext
