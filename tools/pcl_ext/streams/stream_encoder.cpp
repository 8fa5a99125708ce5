// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "streams/stream_encoder.h"

#include <pcl_ext/compression/frame_description.h>
#include <pcl_ext/filters/lidar_clouds.h>
#include <pcl_ext/filters/sensor_preprocessor.h>

#include "clouds/point_fields.h"
#include "console/exit_status.h"
#include "options/setting_options.h"
#include "options/text_values.h"
#include "stream/version1_header.h"
#include "streams/zero_field.h"

#include <algorithm>
#include <iomanip>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

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

/** \brief A cloud without points, but with fields: some drivers send none, or fewer, in
 * clouds of no points. */
pcl::PCLPointCloud2
emptyCloud(const pcl::PCLHeader& header, const std::string& intensity_field)
{
  std::vector<clouds::FileField> fields;
  for (const std::string& name :
       {std::string("x"), std::string("y"), std::string("z"), intensity_field})
    fields.push_back({name, clouds::FileField::Kind::Real, sizeof(float), 1});
  pcl::PCLPointCloud2 cloud;
  clouds::startCloud(fields, 0, 1, cloud);
  cloud.header = header;
  return cloud;
}

/** \brief Whether a cloud has the fields that a law reads. */
bool
hasFieldsOf(const pcl::PCLPointCloud2& cloud,
            IntensityLaw law,
            const std::string& intensity_field)
{
  return hasReadableField(cloud, "x") && hasReadableField(cloud, "y") &&
         hasReadableField(cloud, "z") &&
         (law != IntensityLaw::Native || hasReadableField(cloud, intensity_field));
}

} // namespace

bool
hasPoints(const pcl::PCLPointCloud2& cloud)
{
  const bool is_nothing = cloud.fields.empty() && cloud.data.empty();
  return cloud.width > 0 && cloud.height > 0 && !is_nothing;
}

EncodedSums&
EncodedSums::operator+=(const EncodedSums& part)
{
  frames += part.frames;
  clouds_left_out += part.clouds_left_out;
  if (!part.why_left_out.empty())
    why_left_out = part.why_left_out;
  smallest_edge = std::min(smallest_edge, part.smallest_edge);
  largest_edge = std::max(largest_edge, part.largest_edge);
  all_points += part.all_points;
  points += part.points;
  encoded_points += part.encoded_points;
  points_in_order += part.points_in_order;
  orders.add(part.orders);
  voxels += part.voxels;
  outliers += part.outliers;
  judged_by |= part.judged_by;
  frames_with_outliers += part.frames_with_outliers;
  judged_points += part.judged_points;
  point_outliers += part.point_outliers;
  hidden_voxels += part.hidden_voxels;
  held_voxels += part.held_voxels;
  moving_frames += part.moving_frames;
  bytes += part.bytes;
  point_bytes += part.point_bytes;
  if (warnings == 0)
    first_warning = part.first_warning;
  warnings += part.warnings;
  if (frames_without_them == 0)
    first_without_them = part.first_without_them;
  points_outside_grid += part.points_outside_grid;
  frames_without_them += part.frames_without_them;
  return *this;
}

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

StreamEncoder::StreamEncoder(const EncodingOptions& options,
                             std::string name,
                             bool carries_layout)
: options_(options)
, name_(std::move(name))
, carries_layout_(carries_layout)
, pose_(options.poseOf(name_))
{}

void
StreamEncoder::chooseLaw(const pcl::PCLPointCloud2& cloud)
{
  if (node_)
    return;
  // Messages may have an empty name, files have none.
  std::optional<std::string> frame_id = cloud.header.frame_id;
  if (options_.hasPose(name_) || (frame_id->empty() && !carries_layout_))
    frame_id.reset();
  nodes::SensorNodeSettings settings =
      options_.nodeSettings(options_.lawOf(cloud), frame_id);
  settings.clock = [time = time_] { return *time; };
  settings.carry_layout = carries_layout_;
  law_ = settings.law;
  is_of_lidar_ = pcl_ext::isOfLidar(cloud);
  frame_id_ = settings.global_frame;
  cloud_frame_id_ = cloud.header.frame_id;
  notePose(cloud);
  node_.emplace(settings);
  settings_ = settings;
  if (!options_.namesFrame() && settings.carry_header &&
      frame_id_.size() > io::max_frame_id_size)
    throw UsageError("the frame_id of its clouds has " +
                     std::to_string(frame_id_.size()) + " bytes, and frames carry " +
                     std::to_string(io::max_frame_id_size) +
                     " at most: name a shorter one with --frame-id, or encode with "
                     "--no-header");
  if (!node_->settingsStatus().ok())
    throw UsageError(messageOf(node_->settingsStatus()));
}

void
StreamEncoder::chooseLaw(const std::vector<pcl::PCLPointCloud2>& clouds)
{
  const auto first = std::find_if(clouds.begin(), clouds.end(), hasPoints);
  if (first != clouds.end())
    chooseLaw(*first);
}

bool
StreamEncoder::encode(const pcl::PCLPointCloud2& cloud,
                      const std::string& source,
                      std::vector<std::uint8_t>& bytes,
                      nodes::Time time)
{
  const bool has_points = hasPoints(cloud) || !cloud.data.empty();
  const pcl::PCLPointCloud2 empty =
      has_points ? pcl::PCLPointCloud2()
                 : emptyCloud(cloud.header, options_.intensityField());
  last_cloud_ = EncodedSums();
  chooseLaw(has_points || !cloud.fields.empty() ? cloud : empty);
  // The first cloud of the stream has one.
  pcl::PCLPointCloud2 dark;
  const bool is_dark = law_ == IntensityLaw::Native && hasPoints(cloud) &&
                       !hasReadableField(cloud, options_.intensityField()) &&
                       addZeros(cloud, options_.intensityField(), dark);
  const pcl::PCLPointCloud2& encoded =
      is_dark                                                             ? dark
      : has_points || hasFieldsOf(cloud, law_, options_.intensityField()) ? cloud
                                                                          : empty;
  *time_ = time;
  const nodes::SensorNodeStatus status = node_->encode(encoded, pose_, bytes);
  if (status.code() == nodes::SensorNodeCode::LeftOut) {
    last_cloud_.clouds_left_out = 1;
    last_cloud_.why_left_out = messageOf(status);
    sums_ += last_cloud_;
    return false;
  }
  if (!status.hasFrame())
    throw std::runtime_error(messageOf(status));
  const nodes::SensorNodeStatistics statistics = node_->statistics();
  refuseWhatReadersRefuse(statistics, messageOf(status));
  noteLeftOut(cloud);
  noteIntensity(cloud, source, is_dark);
  noteHeader(cloud, source);
  const bool judges_voxels =
      VoxelOutlierRemoval::isMadeFor(options_.codec().resolution);
  if (sums_.encoded_points == 0 && statistics.outliers_stay && !judges_voxels)
    throw UsageError(messageOf(status));
  if (sums_.encoded_points == 0) {
    noteUnit(cloud, statistics.frame, source);
    if (statistics.frame.voxelization.points_used > 0)
      noteOrder(encoded, bytes.size());
  }
  EncodedSums sums = sumsOf(statistics, bytes.size());
  if (sums.points_in_order > 0)
    sums.orders.add(io::describeFrame(bytes.data(), bytes.size()));
  sums.point_bytes = sums.encoded_points * cloud.point_step;
  // What the rate control changes is told at the end.
  if (status.hasWarning() && status.message().rfind("rate control: ", 0) != 0) {
    sums.warnings = 1;
    sums.first_warning = source + ": " + messageOf(status);
  }
  if (sums.points_outside_grid > 0) {
    sums.frames_without_them = 1;
    sums.first_without_them = source + ": " + messageOf(status);
  }
  last_cloud_ = sums;
  sums_ += last_cloud_;
  if (sums_.encoded_points == 0 && extent_.empty())
    noteExtent(cloud);
  return true;
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

EncodedSums
StreamEncoder::sumsOf(const nodes::SensorNodeStatistics& statistics,
                      std::size_t bytes) const
{
  const PreprocessingStatistics& points = statistics.preprocessing;
  const io::FrameStatistics& frame = statistics.frame;
  EncodedSums sums;
  sums.frames = 1;
  sums.all_points = points.points;
  sums.points = points.points - points.points_not_finite;
  sums.encoded_points = frame.voxelization.points_used;
  sums.points_outside_grid = frame.voxelization.points_outside_grid;
  (frame.coding.has_points ? sums.points_in_order : sums.voxels) = frame.coding.voxels;
  sums.outliers = statistics.outliers_removed;
  if (statistics.judged_points)
    sums.judged_points = sums.points;
  else if (statistics.outliers_stay)
    sums.frames_with_outliers = 1;
  else if (settings_->outlier_removal && sums.encoded_points > 0)
    sums.judged_by = 1u << static_cast<unsigned int>(statistics.density_unit);
  sums.point_outliers = statistics.points_removed;
  sums.hidden_voxels = frame.voxels_hidden;
  sums.held_voxels = frame.voxels_held;
  sums.moving_frames = frame.sensor_motion == io::SensorMotion::Moving ? 1 : 0;
  sums.bytes = bytes;
  sums.smallest_edge = sums.largest_edge = frame.voxelization.resolution;
  return sums;
}

/** \brief Readers take a recording of few bytes and many voxels as forged.
 * \throws std::runtime_error if they refuse the frame; the next one is an I-frame
 */
void
StreamEncoder::refuseWhatReadersRefuse(const nodes::SensorNodeStatistics& statistics,
                                       const std::string& reason)
{
  if (!statistics.frame.exceeds_limits)
    return;
  node_->requestIFrame();
  throw std::runtime_error(
      "the frame has " +
      counted(statistics.frame.coding.voxels,
              statistics.frame.coding.has_points ? "point" : "voxel") +
      " in " + counted(statistics.frame.coding.bytes, "byte") +
      ", which is more than a reader of the recording takes: use a larger "
      "--resolution" +
      (options_.codec().keepsPoints() ? ", or leave out --keep-points" : "") +
      (options_.codec().fields.empty() ? "" : ", or keep fewer --fields") + " (" +
      reason + ")");
}

bool
StreamEncoder::findCorners(const pcl::PCLPointCloud2& cloud,
                           Eigen::Vector4f& min,
                           Eigen::Vector4f& max) const
{
  SensorPreprocessor<NoIntensity> preprocessor(
      NoIntensity(options_.codec().resolution));
  preprocessor.setSensorPose(Eigen::Isometry3d(pose_));
  pcl::PointCloud<pcl::PointXYZI> points;
  if (!preprocessor.process(cloud, points).ok() || points.empty())
    return false;
  min = max = points[0].getVector4fMap();
  for (pcl::PointXYZI& point : points) {
    min = min.cwiseMin(point.getVector4fMap());
    max = max.cwiseMax(point.getVector4fMap());
  }
  return true;
}

void
StreamEncoder::noteUnit(const pcl::PCLPointCloud2& cloud,
                        const io::FrameStatistics& statistics,
                        const std::string& source)
{
  // No sensor of this kind sees as far in metres, and points of one in millimetres are a
  // millimetre apart or more.
  constexpr float suspect_width = 1000.0f;
  constexpr std::size_t enough_points = 100;
  const std::size_t points = statistics.voxelization.points_used;
  const bool has_points = statistics.coding.has_points;
  if (points < enough_points ||
      (!has_points && statistics.voxelization.voxels < points - points / 50))
    return;
  Eigen::Vector4f min;
  Eigen::Vector4f max;
  if (findCorners(cloud, min, max) && (max - min).head<3>().maxCoeff() > suspect_width)
    remarks_[Remark::Unit] = source + ": its points are between " + corner(min) +
                             " and " + corner(max) +
                             (has_points ? "" : ", and hardly two of them in a voxel") +
                             ": if that is in millimetres, --resolution 10 makes " +
                             (has_points ? "an edge of 1 cm" : "voxels of 1 cm");
}

void
StreamEncoder::noteExtent(const pcl::PCLPointCloud2& cloud)
{
  Eigen::Vector4f min;
  Eigen::Vector4f max;
  if (!findCorners(cloud, min, max))
    return;
  extent_ =
      "its first points are between " + corner(min) + " and " + corner(max) + " m";
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
      "of a lidar, points are judged where its clouds are in its own "
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
