// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/sensor_node.h>

#include "options/encoding_options.h"
#include "streams/point_orders.h"

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief Sums over the frames of a stream. */
struct EncodedSums {
  std::size_t frames = 0;
  std::size_t clouds_left_out = 0; ///< as --max-rate had no room for them
  std::string why_left_out;        ///< the last of them
  double smallest_edge = std::numeric_limits<double>::infinity(); ///< used, metres
  double largest_edge = 0.0;                                      ///< likewise
  std::size_t all_points = 0;                                     ///< of the clouds
  std::size_t points = 0;          ///< finite ones of these
  std::size_t encoded_points = 0;  ///< in frames
  std::size_t points_in_order = 0; ///< of these: in scans, which have no voxels
  PointOrders orders;              ///< of these
  std::size_t voxels = 0;
  std::size_t outliers = 0; ///< voxels that --remove-outliers removed
  /** \brief By what it judged voxels: bit i for the DensityUnit of number i. */
  unsigned int judged_by = 0;
  std::size_t frames_with_outliers = 0; ///< that it could not judge
  std::size_t judged_points = 0;        ///< finite ones, if it judged points
  std::size_t point_outliers = 0;       ///< of these removed
  std::size_t hidden_voxels = 0;        ///< by the temporal filter
  std::size_t held_voxels = 0;          ///< likewise, and part of `voxels`
  std::size_t moving_frames =
      0; ///< of a sensor that moves, which it leaves as they are
  std::size_t bytes = 0;
  std::size_t point_bytes = 0;         ///< of encoded points in the clouds
  std::size_t warnings = 0;            ///< frames with one
  std::string first_warning;           ///< with its frame
  std::size_t points_outside_grid = 0; ///< of voxels, and so left out
  std::size_t frames_without_them = 0; ///< from which they are left out
  std::string first_without_them;      ///< the warning of the first such frame

  /** \brief Finite points outside the box. */
  std::size_t
  pointsOutsideBox() const
  {
    const std::size_t kept = points - point_outliers - points_outside_grid;
    return kept > encoded_points ? kept - encoded_points : 0;
  }

  /** \brief Voxels with points, but for removed ones. */
  std::size_t
  occupiedVoxels() const
  {
    return voxels + hidden_voxels - held_voxels;
  }

  EncodedSums&
  operator+=(const EncodedSums& part);
};

/** \brief True for a cloud that can tell what those of its stream have; false for one
 * of no points, in which some drivers send no fields, or other ones. */
bool
hasPoints(const pcl::PCLPointCloud2& cloud);

/** \brief A sentence on points that were left out, as they are outside the grid of
 * voxels; empty if none were. */
std::string
describePointsOutsideGrid(const EncodedSums& sums);

/** \brief A sentence on a stream none of whose clouds had room within --max-rate. */
std::string
describeNoRoom(const std::string& stream, const EncodedSums& sums);

/** \brief What there may be to say of the clouds of a stream, in the order in which it is
 * told. */
enum class Remark {
  LeftOut, ///< what is not encoded of the first clouds with points
  /** \brief The first cloud with intensities that are left out, as the law follows from a
   * cloud without, or without them, in a stream of clouds that have them. */
  Intensity,
  Order,  ///< what --keep-order took in the first frame with points
  Budget, ///< what --max-rate or --max-encode-ms has changed
  /** \brief The first cloud of another coordinate frame where the user names the one of
   * all, or whose time ROS 2 has not, or of which else something is taken otherwise than
   * it is. */
  Header,
  Pose,    ///< fields of the first cloud that --pose does not move
  Colours, ///< of the first cloud of which they are changed
  Unit,    ///< the first cloud with points seems to be in millimetres
  Outliers ///< were to be removed and stay, or are hardly any voxels, or very many
};

/** \brief A sentence on each of which there is something to say. */
using Remarks = std::map<Remark, std::string>;

/** \brief Encodes the clouds of a stream. */
class StreamEncoder {
public:
  /** \param[in] options must outlive this
   * \param[in] name of the stream
   * \param[in] carries_layout its clouds are those of messages, whose layout is coded
   */
  StreamEncoder(const EncodingOptions& options,
                std::string name,
                bool carries_layout = false);

  /** \brief Chooses the law by a cloud, unless that was done.
   * \throws UsageError if the settings are invalid
   */
  void
  chooseLaw(const pcl::PCLPointCloud2& cloud);

  /** \brief The same by the first cloud with points, if there is one. */
  void
  chooseLaw(const std::vector<pcl::PCLPointCloud2>& clouds);

  /** \brief Encodes a cloud.
   * \param[in] cloud the first one decides on the law, if it is automatic
   * \param[in] source of the cloud, for warnings
   * \param[out] bytes the frame
   * \param[in] time of the cloud, for --max-rate
   * \return false: it was left out, as --max-rate has no room for it
   * \throws std::runtime_error if it cannot be encoded
   * \throws UsageError if the settings are invalid
   */
  bool
  encode(const pcl::PCLPointCloud2& cloud,
         const std::string& source,
         std::vector<std::uint8_t>& bytes,
         nodes::Time time = nodes::Time(0));

  /** \brief Makes the next frame an I-frame. */
  void
  requestIFrame()
  {
    if (node_)
      node_->requestIFrame();
  }

  /** \brief The coordinate frame of the voxels; after the first cloud. */
  const std::string&
  frameId() const
  {
    return frame_id_;
  }

  /** \brief The law of the intensities; after the first cloud. */
  IntensityLaw
  law() const
  {
    return law_;
  }

  /** \brief Whether the first cloud is a lidar's, see pcl_ext::isOfLidar(). */
  bool
  isOfLidar() const
  {
    return is_of_lidar_;
  }

  const std::string&
  name() const
  {
    return name_;
  }

  const EncodedSums&
  sums() const
  {
    return sums_;
  }

  /** \brief Statistics of the node; those of none before the first cloud. */
  nodes::SensorNodeStatistics
  statistics() const
  {
    return node_ ? node_->statistics() : nodes::SensorNodeStatistics();
  }

  const EncodedSums&
  lastCloud() const
  {
    return last_cloud_;
  }

  /** \brief Where the points of the first cloud are, if none was inside the crop box;
   * empty if points were encoded, or the clouds have none. */
  std::string
  whyNothingWasEncoded() const;

  /** \brief Notes what is to be said, unless something is noted already.
   * \param[in] subject the stream, or the source of the cloud
   * \param[in] text what follows it; empty: nothing is to be said
   */
  void
  note(Remark about, const std::string& subject, const std::string& text)
  {
    if (!text.empty())
      remarks_.emplace(about, subject + ": " + text);
  }

  /** \brief What there is to say of the clouds until now. */
  Remarks
  remarks() const;

  /** \brief A sentence on the first cloud whose coordinate frame is not that of those
   * before, unless the user names the one of all; empty if there is none. */
  const std::string&
  frameIdError() const
  {
    return frame_id_error_;
  }

private:
  /** \brief What there is to say of Remark::Outliers and Remark::Budget, without the name
   * of the stream; empty: nothing. */
  std::string
  outlierRemark() const;
  std::string
  budgetRemark() const;

  /** \brief Where the finite points of a cloud are in the world. */
  struct Extent {
    Eigen::Vector4f min;
    Eigen::Vector4f max;
    float median_distance; ///< from the origin
  };

  /** \brief The extent of a cloud; none: it has no finite points. */
  std::optional<Extent>
  extentOf(const pcl::PCLPointCloud2& cloud) const;

  void
  notePose(const pcl::PCLPointCloud2& cloud);

  void
  noteIntensity(const pcl::PCLPointCloud2& cloud,
                const std::string& source,
                bool is_dark);

  void
  noteHeader(const pcl::PCLPointCloud2& cloud, const std::string& source);

  void
  noteLeftOut(const pcl::PCLPointCloud2& cloud);

  void
  noteOrder(const pcl::PCLPointCloud2& cloud, std::size_t bytes);

  void
  noteUnit(const pcl::PCLPointCloud2& cloud,
           const io::FrameStatistics& statistics,
           const std::string& source);

  void
  noteExtent(const pcl::PCLPointCloud2& cloud);

  EncodedSums
  sumsOf(const nodes::SensorNodeStatistics& statistics, std::size_t bytes) const;

  void
  refuseWhatReadersRefuse(const nodes::SensorNodeStatistics& statistics,
                          const std::string& reason);

  const EncodingOptions& options_;
  std::string name_;
  bool carries_layout_;
  WorldPose pose_;
  std::optional<nodes::SensorNode> node_;
  std::optional<nodes::SensorNodeSettings> settings_; ///< of node_
  std::string frame_id_;
  std::string cloud_frame_id_; ///< of the first cloud
  std::string frame_id_error_; ///< see frameIdError()
  Remarks remarks_;            ///< but for Budget and Outliers
  IntensityLaw law_ = IntensityLaw::Count;
  bool is_of_lidar_ = false;
  std::shared_ptr<nodes::Time> time_ = std::make_shared<nodes::Time>(); ///< now
  EncodedSums sums_;
  EncodedSums last_cloud_;
  std::string extent_; ///< of the first cloud, in the world
};

} // namespace pcl_ext::tools
