// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What is compressed: the stream's clouds, the intensity law, the voxel edge.
 */
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "clouds/cloud_sequence.h"
#include "measuring/preprocessing.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

using PositionCloud = pcl::PointCloud<pcl::PointXYZ>;
using IntensityCloud = pcl::PointCloud<pcl::PointXYZI>;

/** \brief Settings that all coders of a comparison share. */
struct Workload {
  IntensityLaw law = IntensityLaw::Count;
  double resolution = 0.04; ///< voxel edge, metres
  unsigned int i_frame_rate = 30;
  /** \brief What sensor nodes remove before they encode; none: they send all voxels. */
  std::optional<VoxelOutlierRemovalSettings> outlier_removal;
  unsigned int temporal_filter = 0; ///< of sensor nodes, frames; 0: none
};

/** \brief An effort of this library, or the published layout. */
struct Variant {
  const char* name;
  io::Effort effort;
  io::StreamFormat format;
};

/** \brief This library's efforts from fast to small, and the published layout. */
const std::vector<Variant>&
libraryVariants();

/** \brief Their names, for options. */
std::vector<std::string>
variantNames();

/** \brief The variant of one of variantNames(). */
const Variant&
variantNamed(const std::string& name);

/** \brief Name of a variant in tables with other coders. */
std::string
coderName(const Variant& variant);

/** \brief The settings of a workload, for points whose intensity makePreprocessing()
 * made: their intensities are summed; version 1 has 8 bits and the law's depth model.
 *
 * No box: every coder chooses its own, as PCL's class does, and the published layout
 * then has the same voxels as version 1.
 */
io::IntensityCompressionSettings
compressionSettings(const Workload& workload, const Variant& variant);

/** \brief \throws std::runtime_error with the status's message if it is an error */
void
throwUnlessOk(const io::CompressionStatus& status);

/** \brief One cloud in the types that the coders take. */
struct InputFrame {
  PositionCloud::Ptr raw{new PositionCloud};      ///< the sensor's, in its frame
  IntensityCloud::Ptr points{new IntensityCloud}; ///< preprocessed, world frame
  PositionCloud::Ptr positions{
      new PositionCloud}; ///< of these the positions, for coders without intensity
};

/** \brief The clouds of one sensor and the box that they are cropped to. */
struct InputStream {
  std::unique_ptr<clouds::CloudSequence> clouds;
  std::optional<io::BoundingBox> crop_box;
};

/** \brief The preprocessing of a stream's clouds; see makePreprocessing() of an intensity
 * law. */
Preprocessing<PositionCloud>
makePreprocessing(const Workload& workload, const InputStream& stream);

/** \brief The settings of a sensor's node: number of points as intensity; no colours,
 * so that recordings with and without them compare. */
nodes::SensorNodeSettings
sensorNodeSettings(const InputStream& stream,
                   const Workload& workload,
                   const Variant& variant);

/** \brief The robot cell with its crop box. */
InputStream
openCellStream(unsigned int cell_sensor, std::size_t frames);

/** \brief The robot cell's lidar with the cell's crop box. */
InputStream
openLidarStream(std::size_t revolutions);

/** \brief The recordings in folders, in their sensors' frames, uncropped. */
std::vector<InputStream>
openRecordedStreams(const std::vector<std::string>& folders);

/** \brief Which clouds of a frame to keep. */
enum class Keep { All, Preprocessed };

/** \brief Reads and preprocesses a whole stream in advance, so that nothing else runs
 * between the frames that are measured.
 * \throws std::runtime_error if a frame cannot be read, or has no point, which PCL's
 * class cannot code
 */
std::vector<InputFrame>
readFrames(const InputStream& stream, const Workload& workload, Keep keep);

} // namespace measuring
} // namespace pcl_ext
