// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
// What StreamEncoder says of the clouds of a stream.
#include <pcl_ext/filters/sensor_preprocessor.h>

#include "clouds/point_fields.h"
#include "options/text_values.h"
#include "streams/stream_encoder.h"

#include <algorithm>
#include <cstddef>
#include <iomanip>
#include <limits>
#include <optional>
#include <sstream>
#include <variant>
#include <vector>

namespace pcl_ext::tools {

namespace {

std::string
corner(const Eigen::Vector4f& point)
{
  std::ostringstream text;
  text << std::setprecision(3) << '(' << point.x() << ", " << point.y() << ", "
       << point.z() << ')';
  return text.str();
}

} // namespace

std::string
describePointsOutsideGrid(const EncodedSums& sums)
{
  if (sums.frames_without_them < 2)
    return sums.first_without_them;
  return sums.first_without_them + " (" +
         counted(sums.frames_without_them - 1, "more frame") + " likewise, in all " +
         counted(sums.points_outside_grid, "point") + " of " +
         counted(sums.points, "point") + ")";
}

std::string
describeNoRoom(const std::string& stream, const EncodedSums& sums)
{
  return stream + ": --max-rate has no room for any of its " +
         counted(sums.clouds_left_out, "cloud") +
         ": raise it, --rate-buffer or --rate-doublings, or take a larger "
         "--resolution; at the end: " +
         sums.why_left_out;
}

void
StreamEncoder::notePose(const pcl::PCLPointCloud2& cloud)
{
  if (options_.hasPose(name_) && !pose_.linear().isIdentity())
    for (const char* const normal : {"normal_x", "normal_y", "normal_z"})
      if (options_.keepsField(normal) && hasReadableField(cloud, normal))
        note(Remark::Pose,
             name_,
             "its fields normal_x, normal_y and normal_z are kept as they are, which "
             "does not hold for points that --pose has moved");
}

void
StreamEncoder::noteIntensity(const pcl::PCLPointCloud2& cloud,
                             const std::string& source,
                             bool is_dark)
{
  const bool has_points = hasPoints(cloud) || !cloud.data.empty();
  if (law_ == IntensityLaw::None && has_points &&
      options_.lawOf(cloud) == IntensityLaw::Native)
    note(Remark::Intensity,
         source,
         "its field '" + options_.intensityField() +
             "' is left out, and in later clouds, as the first cloud of the stream has "
             "none" +
             (options_.codec().format == io::StreamFormat::Version1
                  ? "; --fields all keeps it"
                  : ""));
  if (is_dark)
    note(Remark::Intensity,
         source,
         "its points get the intensity 0, and those of later clouds like it, as it has "
         "no field '" +
             options_.intensityField() +
             "' that can be read; the first cloud of the stream has one");
}

void
StreamEncoder::noteHeader(const pcl::PCLPointCloud2& cloud, const std::string& source)
{
  // Empty names tell nothing.
  if (!cloud.header.frame_id.empty() && !cloud_frame_id_.empty() &&
      cloud.header.frame_id != cloud_frame_id_) {
    const std::string text =
        "its frame_id is '" + cloud.header.frame_id + "', that of the clouds before '" +
        cloud_frame_id_ + "'; all points of a stream are in one coordinate frame, '" +
        frame_id_ + "'";
    if (options_.namesFrame())
      note(Remark::Header, source, text);
    else if (frame_id_error_.empty())
      frame_id_error_ = source + ": " + text;
  }
  constexpr std::uint64_t microseconds = 1'000'000;
  if (cloud.header.stamp / microseconds > std::numeric_limits<std::int32_t>::max())
    note(Remark::Header,
         source,
         "its time is after 2038, which messages of ROS 2 do not have: theirs have the "
         "same bits, those of a time before 1970");
}

void
StreamEncoder::noteLeftOut(const pcl::PCLPointCloud2& cloud)
{
  if (remarks_.count(Remark::LeftOut) > 0)
    return;
  const std::string left_out = nodes::describeLeftOut(cloud, *settings_);
  if (left_out.empty())
    return;
  const auto& kept = options_.codec().fields;
  const bool are_all = std::any_of(kept.begin(), kept.end(), [](const auto& field) {
    return field.name == io::all_fields;
  });
  const bool may_keep_more =
      !are_all && options_.codec().format == io::StreamFormat::Version1;
  note(Remark::LeftOut,
       name_,
       left_out + (left_out.rfind("fields", 0) == 0 && may_keep_more
                       ? "; --fields keeps fields"
                       : ""));
}

/** \brief Notes what a frame would take if its points had another order, by encoding it
 * again; not with a budget, which may have changed the frame, nor for very many points,
 * which take long. */
void
StreamEncoder::noteOrder(const pcl::PCLPointCloud2& cloud, std::size_t bytes)
{
  const io::EncoderSettings& codec = settings_->compression;
  constexpr std::uint64_t most_points = 1000000;
  if (!codec.keep_order || codec.max_rate > 0.0 || codec.max_encode_ms > 0.0 ||
      std::uint64_t{cloud.width} * cloud.height > most_points)
    return;
  nodes::SensorNodeSettings settings = *settings_;
  settings.compression.keep_order = false;
  settings.compression.keep_points = true;
  std::vector<std::uint8_t> unordered;
  if (!nodes::SensorNode(settings).encode(cloud, pose_, unordered).hasFrame())
    return;
  const std::size_t more = bytes - std::min(bytes, unordered.size());
  note(Remark::Order,
       name_,
       "the order of the points takes " + (more > 0 ? counted(more, "byte") : "none") +
           " of the " + counted(bytes, "byte") + " of the first frame with points");
}

std::optional<StreamEncoder::Extent>
StreamEncoder::extentOf(const pcl::PCLPointCloud2& cloud) const
{
  SensorPreprocessor<NoIntensity> preprocessor(
      NoIntensity(options_.codec().resolution));
  preprocessor.setSensorPose(Eigen::Isometry3d(pose_));
  pcl::PointCloud<pcl::PointXYZI> points;
  if (!preprocessor.process(cloud, points).ok() || points.empty())
    return std::nullopt;
  Extent extent{points[0].getVector4fMap(), points[0].getVector4fMap(), 0.0f};
  std::vector<float> distances;
  for (const pcl::PointXYZI& point : points) {
    extent.min = extent.min.cwiseMin(point.getVector4fMap());
    extent.max = extent.max.cwiseMax(point.getVector4fMap());
    distances.push_back(point.getVector3fMap().norm());
  }
  const auto middle =
      distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  extent.median_distance = *middle;
  return extent;
}

void
StreamEncoder::noteUnit(const pcl::PCLPointCloud2& cloud,
                        const io::FrameStatistics& statistics,
                        const std::string& source)
{
  // No sensor of this kind sees as far in metres, but for errors, and points of one in
  // millimetres are a millimetre apart or more.
  constexpr float suspect_width = 1000.0f;
  constexpr float suspect_distance = 100.0f;
  constexpr std::size_t enough_points = 100;
  const std::size_t points = statistics.voxelization.points_used;
  const bool has_points = statistics.coding.has_points;
  if (points < enough_points ||
      (!has_points && statistics.voxelization.voxels < points - points / 50))
    return;
  const std::optional<Extent> extent = extentOf(cloud);
  if (!extent)
    return;
  // Points far from the origin, beside their width, are those of a map in metres.
  const float width = (extent->max - extent->min).head<3>().maxCoeff();
  if (width > suspect_width && extent->median_distance > suspect_distance &&
      extent->median_distance < 2.0f * width)
    remarks_[Remark::Unit] = source + ": its points are between " +
                             corner(extent->min) + " and " + corner(extent->max) +
                             (has_points ? "" : ", and hardly two of them in a voxel") +
                             ": if that is in millimetres, --resolution 10 makes " +
                             (has_points ? "an edge of 1 cm" : "voxels of 1 cm");
}

void
StreamEncoder::noteExtent(const pcl::PCLPointCloud2& cloud)
{
  if (const std::optional<Extent> extent = extentOf(cloud))
    extent_ = "its first points are between " + corner(extent->min) + " and " +
              corner(extent->max) + " m";
}

Remarks
StreamEncoder::remarks() const
{
  Remarks remarks = remarks_;
  if (const std::string budget = budgetRemark(); !budget.empty())
    remarks[Remark::Budget] = name_ + ": " + budget;
  if (const std::string outliers = outlierRemark(); !outliers.empty())
    remarks[Remark::Outliers] = name_ + ": " + outliers;
  return remarks;
}

std::string
StreamEncoder::outlierRemark() const
{
  constexpr std::size_t hardly_any = 1000; // one of so many
  constexpr std::size_t very_many = 4;
  const bool judges_voxels =
      VoxelOutlierRemoval::isMadeFor(options_.codec().resolution);
  if (sums_.frames_with_outliers > 0 && judges_voxels) // else each frame has a warning
    return "outliers stay in " + counted(sums_.frames_with_outliers, "frame") + " of " +
           std::to_string(sums_.frames) +
           ", as --max-rate took voxels that are too large to be judged: "
           "--rate-doublings limits their edge";
  if (sums_.judged_by == 0)
    return {};
  const std::string removed = counted(sums_.outliers, "voxel") + " of " +
                              counted(sums_.outliers + sums_.voxels, "voxel") +
                              " removed as outliers, ";
  const std::string remedy =
      "for a lidar, points are judged where its clouds are in its own "
      "coordinates, best with rows and columns or a field 'ring', and "
      "--unit rays judges voxels";
  if (very_many * sums_.outliers > sums_.outliers + sums_.voxels)
    return removed + "which is more than noise usually is: " + remedy;
  constexpr unsigned int by_voxels = 1u
                                     << static_cast<unsigned int>(DensityUnit::Voxels);
  if (sums_.judged_by != by_voxels || hardly_any * sums_.outliers >= sums_.voxels)
    return {};
  const bool is_named =
      !std::holds_alternative<AutomaticUnit>(settings_->outlier_removal->unit);
  return removed +
         "judged by nothing but whether voxels are occupied: a depth camera's "
         "noise is found with --law count or quadratic" +
         (is_named ? " and without --unit; " : "; ") + remedy;
}

std::string
StreamEncoder::budgetRemark() const
{
  const io::RateControlStatus status = statistics().rate_control;
  if (status.changes == 0 && status.not_kept.empty())
    return {};
  return "rate control, " + counted(status.changes, "change") +
         ", at the end: " + status.choice +
         (status.changes > 0 ? ", as " + status.reason : "") +
         (status.not_kept.empty() ? "" : "; " + status.not_kept);
}

std::string
StreamEncoder::whyNothingWasEncoded() const
{
  // An empty cloud is a valid frame.
  if (sums_.all_points == 0 || sums_.encoded_points > 0)
    return {};
  if (extent_.empty())
    return name_ + ": no cloud has a point with finite coordinates below 3.4e38 m";
  const bool has_box = settings_->crop_box || options_.codec().bounding_box;
  return name_ + ": no point is inside " +
         (has_box ? "the box" : "the grid of voxels around --origin") + "; " + extent_ +
         ": choose --crop, --bounding-box or --origin to hold some of them";
}

} // namespace pcl_ext::tools
