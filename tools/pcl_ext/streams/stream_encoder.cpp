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

#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

namespace pcl_ext::tools {

namespace {

/** \brief A cloud without points, but with fields: some drivers send none, or fewer, in
 * clouds of no points. */
pcl::PCLPointCloud2
emptyCloud(const pcl::PCLHeader& header, const std::string& intensity_field)
{
  std::vector<clouds::FileField> fields;
  for (const std::string& name :
       {std::string("x"), std::string("y"), std::string("z"), intensity_field})
    fields.push_back({name, clouds::FieldKind::Real, sizeof(float), 1});
  pcl::PCLPointCloud2 cloud;
  clouds::startCloud(fields, 0, 1, cloud);
  cloud.header = header;
  return cloud;
}

/** \brief Makes a cloud with a further field of zeros, FLOAT32, behind the other bytes of
 * a point, without the fields of that name, which cannot be read.
 * \return false: not all points are within the data
 */
bool
addZeros(const pcl::PCLPointCloud2& cloud,
         const std::string& name,
         pcl::PCLPointCloud2& with_zeros)
{
  const std::size_t row_step = rowStep(cloud);
  const std::size_t row = std::size_t{cloud.width} * cloud.point_step;
  if (row == 0 || row > row_step || cloud.data.size() < row ||
      (cloud.data.size() - row) / row_step + 1 < cloud.height)
    return false;
  const std::size_t new_row = row + std::size_t{cloud.width} * sizeof(float);
  if (new_row > std::numeric_limits<std::uint32_t>::max())
    return false;
  with_zeros.header = cloud.header;
  with_zeros.width = cloud.width;
  with_zeros.height = cloud.height;
  with_zeros.is_bigendian = cloud.is_bigendian;
  with_zeros.is_dense = cloud.is_dense;
  with_zeros.fields.clear();
  std::copy_if(cloud.fields.begin(),
               cloud.fields.end(),
               std::back_inserter(with_zeros.fields),
               [&name](const auto& field) { return field.name != name; });
  pcl::PCLPointField& zeros = with_zeros.fields.emplace_back();
  zeros.name = name;
  zeros.offset = cloud.point_step;
  zeros.datatype = pcl::PCLPointField::FLOAT32;
  zeros.count = 1;
  with_zeros.point_step = cloud.point_step + static_cast<std::uint32_t>(sizeof(float));
  with_zeros.row_step = static_cast<std::uint32_t>(new_row);
  with_zeros.data.assign(std::size_t{with_zeros.row_step} * cloud.height, 0);
  for (std::size_t i = 0; i < cloud.height; ++i)
    for (std::size_t k = 0; k < cloud.width; ++k)
      std::copy_n(
          &cloud.data[i * row_step + k * cloud.point_step],
          cloud.point_step,
          &with_zeros.data[i * with_zeros.row_step + k * with_zeros.point_step]);
  return true;
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

} // namespace pcl_ext::tools
