// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/rate_control_status.h>
#include <pcl_ext/export.h>
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/intensity/intensity_law.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/nodes/stream_health.h>
#include <pcl_ext/rigid_pose.h>
#include <pcl_ext/status.h>

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \addtogroup nodes
 * @{ */

/** \brief All settings of a SensorNode, with their units, defaults and ranges. */
struct SensorNodeSettings {
  /** \brief Resolution, effort, format, I-frame rate, bits and so on. Without a
   * `bounding_box` the grid is that of the crop box, if there is one.
   * Clouds with a colour are sent with it, unless `colour_bits` is 0 or the format is
   * Published; colours can double the size of a frame. Clouds without cost nothing.
   */
  io::EncoderSettings compression;

  /** \brief Law of the point intensities. */
  IntensityLaw law = automaticLaw(false);

  /** \brief Field of view and size of the depth image; needed by the quadratic and the
   * linear law only. As runtimeSensor(KinectV2()). */
  std::optional<RuntimeSensor> sensor;

  /** \brief Field that the native law reads. */
  std::string intensity_field = "intensity";

  /** \brief Points outside of it are left out: world coordinates, metres, both ends
   * included, min < max on each axis; without a `bounding_box` the limits of that hold.
   * None: all points stay. */
  std::optional<io::BoundingBox> crop_box;

  /** \brief Removes outliers before the cloud is encoded; noise is the most expensive
   * part of a frame. None: all is sent, and a receiver may remove outliers.
   *
   * With the unit Automatic the clouds of a lidar that turns lose points that are noise
   * in the air, see PointOutlierRemoval, with these min_log_odds and use_history; all
   * others lose voxels, by the unit of the law, see densityUnitOf(). Name a unit to
   * judge voxels in any case. Voxels are judged at the edges that VoxelOutlierRemoval is
   * made for; a frame that could not be judged has a warning. Without a sensor_position
   * it is that of the cloud's transform; intensities of the law Count are numbers of
   * points. */
  std::optional<VoxelOutlierRemovalSettings> outlier_removal;

  /** \brief Code the stamp of the cloud and global_frame; not in the published
   * layout. */
  bool carry_header = false;

  /** \brief Code the layout of the clouds' messages, so that decoded ones have it again;
   * without effect in the published layout. */
  bool carry_layout = false;

  /** \brief Name of the world's coordinate frame, part of the frames if carry_header is
   * set; at most 1024 bytes then. */
  std::string global_frame = "world";

  /** \brief Clock for rates and latencies. */
  Clock clock = systemTime;
};

/** \brief What of a cloud a SensorNode does not encode: fields besides coordinates,
 * colour and the intensity, on which the law decides, the rows and columns of an
 * organised cloud, and a layout that is too large; and what it takes otherwise than the
 * cloud tells it.
 * \return words for the user, the same for all clouds with these fields; empty if there
 * is nothing, or the cloud is invalid
 */
PCL_EXT_EXPORT std::string
describeLeftOut(const pcl::PCLPointCloud2& cloud, const SensorNodeSettings& settings);

/** \brief Outcome codes of SensorNode::encode. */
enum class SensorNodeCode {
  Ok,                ///< encoded, with the given transform
  UsedLastTransform, ///< encoded, with the last transform, as none was given
  InvalidSettings,   ///< a setting is outside its range, or two contradict each other
  NoTransform,       ///< not encoded: no transform with this cloud or an earlier one
  InvalidTransform,  ///< not encoded: the transform is not a rigid transform
  InvalidCloud,      ///< not encoded: invalid fields or sizes of the cloud
  EncodingFailed,    ///< not encoded: the encoder refused the frame, or the clock threw
  OutOfMemory,       ///< not encoded: memory ran out; the next frame is an I-frame
  LeftOut            ///< not encoded: compression.max_rate has no room for it now
};

/** \brief Outcome of encoding a cloud. With UsedLastTransform there is a frame, too:
 * hasFrame() and not ok() says whether there is something to send. */
struct SensorNodeStatus : Status<SensorNodeCode> {
  using Status<SensorNodeCode>::Status;

  /** \brief True if there is a frame to send. */
  bool
  hasFrame() const
  {
    return code() == SensorNodeCode::Ok || code() == SensorNodeCode::UsedLastTransform;
  }
};

/** \brief Statistics of a SensorNode since its construction. Every cloud is counted as
 * a frame, as left out without a transform or without room, or as refused. */
struct SensorNodeStatistics {
  std::size_t frames = 0;
  std::size_t i_frames = 0;                   ///< of the frames
  std::size_t frames_with_last_transform = 0; ///< of the frames
  std::size_t clouds_without_transform = 0;   ///< left out
  io::RateControlStatus rate_control;         ///< with the clouds without room
  std::size_t clouds_refused = 0; ///< invalid cloud or transform, or out of memory
  std::uint64_t cloud_bytes = 0;  ///< of the clouds that became frames
  std::uint64_t frame_bytes = 0;  ///< of the frames
  PreprocessingStatistics preprocessing; ///< of the last frame
  std::size_t outliers_removed = 0;      ///< voxels left out of the last frame
  /** \brief Outliers stay in the last frame, as its points are not those of a lidar and
   * VoxelOutlierRemoval is not made for the voxel edge, that of the settings or of the
   * rate control. */
  bool outliers_stay = false;
  DensityUnit density_unit = DensityUnit::Automatic; ///< its voxels were judged by
  bool judged_points = false;     ///< outliers of the last cloud were told by its rays
  std::size_t points_removed = 0; ///< outliers of the last cloud; not part of the frame
  std::size_t decoded_width = 0;  ///< of the cloud that the last frame is decoded to
  std::uint32_t decoded_height = 1;
  bool decoded_doubles = false;                     ///< its coordinates are FLOAT64
  std::vector<io::FieldDescription> decoded_fields; ///< its further fields
  /** \brief The layout that its message gets; null: none. */
  std::shared_ptr<const io::MessageLayout> decoded_layout;
  io::FrameStatistics frame; ///< of the last frame
  StreamRates rates;
  DurationHistogram encode_times; ///< computing times of the frames

  /** \brief Bytes of the clouds against bytes of the frames; 0 before the first. */
  double
  compressionRatio() const
  {
    return frame_bytes == 0
               ? 0.0
               : static_cast<double>(cloud_bytes) / static_cast<double>(frame_bytes);
  }
};

/** \brief The part of the computer at one sensor: preprocesses, voxelizes and
 * compresses each cloud (sections 2.2 to 2.6 of the paper). Independent of ROS.
 *
 * An instance serves one sensor and one thread at a time. A moved-from instance may
 * only be destroyed or assigned to.
 */
class PCL_EXT_EXPORT SensorNode {
public:
  /** \brief A node at the start of its stream.
   * \param[in] settings checked here; see settingsStatus()
   */
  explicit SensorNode(const SensorNodeSettings& settings);
  ~SensorNode();
  SensorNode(SensorNode&&) noexcept;
  SensorNode&
  operator=(SensorNode&&) noexcept;

  /** \brief Ok, or InvalidSettings with the setting and its value; encode() then
   * returns the same for every cloud. */
  const SensorNodeStatus&
  settingsStatus() const;

  /** \brief Turns the sensor's next cloud into the stream's next frame.
   *
   * The transform is used for this cloud, and for following ones without a transform.
   * Before the first transform nothing is encoded. Does not throw: after OutOfMemory
   * the next frame is an I-frame.
   * \param[in] cloud in the sensor's frame (x right, y down, z along the optical axis),
   * metres; fields as SensorPreprocessor::process finds them; stamp in microseconds
   * \param[in] sensor_to_world rotation and translation at the time of the cloud,
   * metres; none: unknown
   * \param[out] bytes the frame; empty unless hasFrame() of the status
   * \return see SensorNodeCode; a frame may come with a warning, see
   * CloudEncoder::encode, or with what the rate control changed. What the settings leave
   * out of each cloud, as fields of other datatypes, is told by describeLeftOut().
   */
  SensorNodeStatus
  encode(const pcl::PCLPointCloud2& cloud,
         const std::optional<WorldPose>& sensor_to_world,
         std::vector<std::uint8_t>& bytes);

  /** \brief Makes the next frame an I-frame, for a new receiver or one that lost a
   * frame. */
  void
  requestIFrame();

  /** \brief Changes compression.max_rate as the link does, bits a second above 0; only
   * where there is one. */
  void
  setMaxRate(double bits_per_second);

  /** \brief Statistics until now. */
  SensorNodeStatistics
  statistics() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::nodes
