/** \file
 * \brief What is compressed: the stream's clouds, the intensity law, the voxel edge.
 */
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_encoder.h>
#include <pcl_ext/compression/voxelizer.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "measuring/cloud_sequence.h"

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

/** \brief The intensity of a point; its sum is the voxel's. */
enum class Law { Count, Quadratic };

/** \brief What all coders of one comparison are set to. */
struct Workload {
  Law law = Law::Count;
  double resolution = 0.04; ///< voxel edge, metres
  unsigned int i_frame_rate = 30;
  /** \brief What sensor nodes remove before they encode; none: they send all voxels. */
  std::optional<VoxelOutlierRemovalSettings> outlier_removal;
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

/** \brief One of these.
 * \throws std::invalid_argument if there is none of this name
 */
Variant
variantNamed(const std::string& name);

/** \brief A variant's name beside other coders. */
std::string
coderName(const Variant& variant);

/** \brief Settings for points that carry their intensity already.
 *
 * No box: every coder chooses its own, as PCL's class does, and the published layout
 * then has the same voxels as version 1.
 */
io::IntensityCompressionSettings
compressionSettings(const Workload& workload, const Variant& variant);

/** \brief Preprocessed points as the voxelizer wants them; at least one. */
io::PointView
viewOf(const IntensityCloud& points);

/** \brief The encoder that the settings ask for. */
io::FrameEncoder
makeFrameEncoder(const io::IntensityCompressionSettings& settings);

/** \brief SensorPreprocessor with a law chosen when the program runs. */
using Preprocessing = std::function<void(const PositionCloud&, IntensityCloud&)>;

/** \brief The preprocessing of a workload.
 * \param[in] workload law and voxel edge
 * \param[in] sensor_pose sensor -> world
 * \param[in] crop_box what to keep, world; none: everything
 * \return a function that throws std::runtime_error where preprocessing fails
 */
Preprocessing
makePreprocessing(const Workload& workload,
                  const Eigen::Isometry3d& sensor_pose,
                  const std::optional<io::BoundingBox>& crop_box);

/** \brief One cloud as each coder wants it. */
struct InputFrame {
  PositionCloud::Ptr raw{new PositionCloud};      ///< the sensor's, in its frame
  IntensityCloud::Ptr points{new IntensityCloud}; ///< preprocessed, world frame
  PositionCloud::Ptr positions{
      new PositionCloud}; ///< of these the positions, for coders without intensity
};

/** \brief The clouds of one sensor, and what is kept of them. */
struct InputStream {
  std::unique_ptr<CloudSequence> clouds;
  std::optional<io::BoundingBox> crop_box;
};

/** \brief The robot cell with its crop box. */
InputStream
openCellStream(unsigned int sensor, std::size_t frames);

/** \brief The robot cell's lidar with the cell's crop box. */
InputStream
openLidarStream(std::size_t revolutions);

/** \brief The recordings in folders, in their sensors' frames, uncropped. */
std::vector<InputStream>
openRecordedStreams(const std::vector<std::string>& folders);

/** \brief What of the frames to keep. */
enum class Keep { All, Preprocessed };

/** \brief Reads and preprocesses a whole stream, so that nothing else comes between the
 * frames when they are measured: coders with trees of small nodes, as PCL's class, take
 * twice the time when something empties the caches before each frame.
 * \throws std::runtime_error if a frame cannot be read, or has no point, which PCL's class
 * cannot code
 */
std::vector<InputFrame>
readFrames(const InputStream& stream, const Workload& workload, Keep keep);

} // namespace measuring
} // namespace pcl_ext
