// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "streams/stream_decoder.h"

#include "console/exit_status.h"
#include "inputs/stream_metadata.h"
#include "options/text_values.h"
#include "outliers/unit_choice.h"
#include "voxels/point_voxels.h"

#include <algorithm>
#include <array>
#include <utility>
#include <variant>
#include <vector>

namespace pcl_ext::tools {

std::string
reasonOf(const io::CompressionStatus& status)
{
  if (status.code() == io::CompressionCode::MissingReference)
    return "it needs a frame before it that is missing or was not decoded; decoding "
           "goes "
           "on with the next I-frame";
  std::string reason = status.message();
  const std::string number = " of frame ";
  if (const std::size_t begin = reason.find(number); begin != std::string::npos) {
    const std::size_t end =
        reason.find_first_not_of("0123456789", begin + number.size());
    reason.erase(begin, std::min(end, reason.size()) - begin);
  }
  return reason;
}

std::optional<std::array<double, 3>>
positionOf(const StreamMetadata& metadata)
{
  const auto found = metadata.find(pose_metadata);
  if (found == metadata.end())
    return std::nullopt;
  try {
    const std::vector<double> pose = parseNumbers(pose_metadata, found->second);
    return pose.size() == 7 ? std::optional(std::array{pose[0], pose[1], pose[2]})
                            : std::nullopt;
  }
  catch (const UsageError&) {
    return std::nullopt;
  }
}

VoxelOutlierRemovalSettings
outlierRemovalOf(const DecodingOptions& options,
                 const StreamMetadata& metadata,
                 const io::VoxelFrame& first)
{
  const std::optional<IntensityLaw> law = lawOf(metadata);
  VoxelOutlierRemovalSettings settings;
  settings.unit =
      options.unit == DensityUnit::Automatic
          ? automaticUnitOf(first, law, isOfLidar(metadata))
          : densityUnitSettings(options.unit, {{}, law == IntensityLaw::Count});
  if (auto* const rays = std::get_if<RaysUnit>(&settings.unit))
    rays->sensor_position =
        options.sensor_position ? options.sensor_position : positionOf(metadata);
  return settings;
}

std::string
unitFaultOf(const DecodingOptions& options,
            const StreamMetadata& metadata,
            bool has_point_counts)
{
  const std::optional<IntensityLaw> law = lawOf(metadata);
  if (!law || (options.unit == DensityUnit::Points && has_point_counts))
    return {};
  const std::string fault = unitFault(options.unit, *law);
  return fault.empty()
             ? fault
             : std::string("--unit is ") + nameOf(density_units, options.unit) +
                   " and the intensity_law of the stream is " + fault;
}

void
remarkOnMemory(const io::DecoderLimits& limits, Console& console)
{
  const std::size_t drops = limits.budget->drops();
  if (drops > 0)
    console.remark(
        "the state of streams was dropped " + counted(drops, "time") +
        " to keep --memory-limit; those that go on are decoded again from an "
        "I-frame on, which takes time, and outliers are judged anew");
}

StreamDecoder::StreamDecoder(recording::RecordingReader& reader,
                             std::size_t stream,
                             const std::string& name,
                             const DecodingOptions& options,
                             io::VoxelFrame& voxels)
: decoder_(reader, stream, options.limits)
, name_(name)
, options_(options)
, metadata_(reader.streams()[stream].metadata)
, voxels_(voxels)
, is_automatic_(options.unit == DensityUnit::Automatic)
{
  decoder_.setDecodesVoxels(false);
}

void
StreamDecoder::makeRemoval()
{
  const std::optional<IntensityLaw> law = lawOf(metadata_);
  if (const std::string fault =
          unitFaultOf(options_, metadata_, voxels_.has_point_counts);
      !fault.empty())
    throw UsageError(name_ + ": " + fault);
  if (is_automatic_ && !law && !voxels_.points.sensor)
    remark_ = name_ + ": the recording does not tell what its intensities are; for "
                      "counts of a depth camera --unit points removes more outliers, "
                      "for a lidar --unit rays does";
  removal_ = std::make_unique<Removal>(outlierRemovalOf(options_, metadata_, voxels_),
                                       options_.limits.budget);
}

void
StreamDecoder::removeOutliers(std::size_t number)
{
  if (!removal_)
    makeRemoval();
  removal_->share.begin();
  if (!removal_->filter)
    removal_->filter.emplace(removal_->settings);
  const OutlierRemovalStatus removed = removal_->filter->filter(voxels_);
  unit_ = removal_->filter->unit();
  decoded_voxels_ = voxels_.size() + removed.removed;
  removal_->share.end(VoxelOutlierRemoval::bytes_of_voxel * decoded_voxels_);
  has_intensities_ &= voxels_.hasIntensities();
  judged_ += removed.ok() ? decoded_voxels_ : 0;
  removed_ += removed.removed;
  if (!removed.ok() && !std::exchange(outliers_stay_, true))
    remark_ = name_ + ", frame " + std::to_string(number) +
              ": outliers stay: " + removed.message();
}

io::CompressionStatus
StreamDecoder::decode(const recording::RecordedFrame& frame)
{
  io::CompressionStatus status = decoder_.decode(frame, voxels_);
  if (!status.ok())
    return status;
  decoded_voxels_ = voxels_.size();
  if (options_.removes_outliers)
    removeOutliers(frame.number);
  if (options_.min_intensity) {
    // A scan has no voxels as long as nothing needs them.
    if (!voxels_.hasIntensities() && (voxels_.size() > 0 || voxels_.pointCount() > 0)) {
      lacks_intensities_ = true;
      has_intensity_field_ |= io::hasField(voxels_.fields, "intensity");
    }
    const std::size_t removed = removeVoxelsBelow(voxels_, *options_.min_intensity);
    if (!options_.removes_outliers)
      decoded_voxels_ = voxels_.size() + removed;
  }
  return io::statusOfVoxels(voxels_);
}

std::optional<DensityUnit>
StreamDecoder::judgedBy() const
{
  return judged_ > 0 ? unit_ : std::nullopt;
}

std::string
StreamDecoder::remark() const
{
  if (outliers_stay_)
    return remark_;
  if (lacks_intensities_)
    return remarkWithoutIntensities(name_) +
           (has_intensity_field_
                ? "; those of its points are a further field: encode with --law native"
                : "");
  const std::optional<DensityUnit> unit = judgedBy();
  constexpr std::size_t hardly_any = 1000; // one of so many
  constexpr double fine = 0.05;            // metres
  const bool removes_hardly_any = hardly_any * removed_ < judged_;
  const std::string counts = name_ + ": " + counted(removed_, "voxel") + " of " +
                             counted(judged_, "voxel") + " removed as outliers: ";
  if (unit == DensityUnit::Rays && removes_hardly_any && voxels_.grid.resolution < fine)
    return counts +
           "in voxels below 0.05 m rays hardly tell noise from surfaces; encode "
           "with larger ones, or with --remove-outliers, which judges points";
  constexpr std::size_t very_many = 4;
  if (unit && very_many * removed_ > judged_)
    return counts + "more than noise usually is" +
           (unit == DensityUnit::Faces
                ? "; for counts name --unit points, for a lidar --unit rays"
            : unit != DensityUnit::Rays
                ? "; for a lidar, --unit rays judges by what its rays would hit"
            : is_automatic_ ? ""
                            : "; --sensor-position tells where the lidar is");
  const bool may_be_lidar =
      unit == DensityUnit::Voxels || (unit == DensityUnit::Points && is_automatic_);
  if (!may_be_lidar)
    return {};
  if (!remark_.empty() && has_intensities_)
    return remark_;
  const bool knows_densities =
      has_intensities_ && (unit == DensityUnit::Points || !is_automatic_);
  if (!removes_hardly_any || (knows_densities && !is_automatic_))
    return {};
  const std::string line = counts + "for a lidar, --unit rays finds noise such as snow";
  return knows_densities || voxels_.has_point_counts ||
                 lawOf(metadata_) == IntensityLaw::Count
             ? line
             : line +
                   "; the recording does not tell how many points a voxel had, by "
                   "which the noise of a depth camera is found; it does where it was "
                   "encoded with --law count";
}

} // namespace pcl_ext::tools
