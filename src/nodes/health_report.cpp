// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/nodes/impl/health_report.h>

#include <sstream>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

/** \brief Time without arrivals after which a stream has stopped. */
constexpr Time silence = std::chrono::seconds(2);

/** \brief Raises the level if nothing arrived, or nothing within the last two seconds.
 * \param[in] what arrives, in the plural
 */
void
checkArrival(const std::string& what,
             const std::optional<Time>& last_arrival,
             Time time,
             HealthReport& report)
{
  if (!last_arrival)
    report.raise(HealthLevel::Stale, "No " + what + " have arrived yet");
  else if (time - *last_arrival > silence)
    report.raise(HealthLevel::Error, "No " + what + " arrive");
  if (last_arrival)
    report.add("seconds since the last " + what.substr(0, what.size() - 1),
               std::chrono::duration<double>(time - *last_arrival).count());
}

void
addRates(const StreamRates& rates, HealthReport& report)
{
  constexpr double milliseconds = 1e3; // per second
  report.add("frames per second", rates.frames_per_second);
  report.add("bytes per second", rates.bytes_per_second);
  report.add("mean cycle time, ms", milliseconds * rates.mean_cycle_seconds);
  report.add("max cycle time, ms", milliseconds * rates.max_cycle_seconds);
  report.add("mean latency, ms", milliseconds * rates.mean_latency_seconds);
  report.add("max latency, ms", milliseconds * rates.max_latency_seconds);
}

/** \brief Bytes of the voxels as points of 16 bytes against bytes of the frames. */
double
compressionRatio(const StreamHealth& stream)
{
  constexpr double bytes_per_point = 16.0;
  const double voxels = static_cast<double>(stream.voxels * stream.frames_received);
  return stream.bytes == 0
             ? 0.0
             : bytes_per_point * voxels / static_cast<double>(stream.bytes);
}

/** \brief Whether a stream has larger voxels than the grid that it is merged on, each
 * of which takes the place of one of several. */
bool
leavesGaps(const StreamHealth& stream, double merged_resolution)
{
  constexpr double tolerance = 1e-6; // published streams have their resolution as float
  return merged_resolution > 0.0 &&
         stream.resolution > merged_resolution * (1.0 + tolerance);
}

std::string
gapsOf(const StreamHealth& stream, double merged_resolution)
{
  std::ostringstream text;
  text << "Voxels have an edge of " << stream.resolution
       << " m, those of the merged grid and the map " << merged_resolution
       << " m, where they leave gaps: set a resolution that is not finer than theirs";
  return text.str();
}

void
judge(const ReceiverHealth& now, const ReceiverHealth& before, HealthReport& report)
{
  const StreamHealth& stream = now.stream;
  if (now.left_out > before.left_out)
    report.raise(HealthLevel::Error, "Frames are of another frame id or format");
  if (stream.frames_failed > before.stream.frames_failed)
    report.raise(HealthLevel::Warning, "Frames fail: " + stream.last_failure.message());
  if (stream.frames_refused > before.stream.frames_refused)
    report.raise(HealthLevel::Warning, "Frames arrive faster than they are decoded");
  if (stream.frames_lost > before.stream.frames_lost)
    report.raise(HealthLevel::Warning, "Frames are lost");
  if (!stream.outlier_removal.ok())
    report.raise(HealthLevel::Warning, "Outliers: " + stream.outlier_removal.message());
  if (now.min_intensity > 0.0f && stream.voxels > 0 && !stream.has_intensities)
    report.raise(HealthLevel::Warning,
                 "min_intensity has no effect: the frames have no intensities");
  if (stream.voxels > 0 && stream.kept_voxels == 0)
    report.raise(HealthLevel::Warning, "All voxels are removed as noise");
  // As where a lidar is judged as a depth camera.
  if (2 * stream.outliers_removed > stream.voxels)
    report.raise(
        HealthLevel::Warning,
        "Most voxels are removed as outliers: density_unit may not fit the sensor");
  if (stream.points_outside_grid > before.stream.points_outside_grid)
    report.raise(
        HealthLevel::Warning,
        "Points of scans are left out, as they are outside the grid of voxels");
  for (const std::string& fault : faultsOfMerging(stream, now.merged_resolution))
    report.raise(HealthLevel::Warning, fault);
}

} // namespace

std::vector<std::string>
faultsOfMerging(const StreamHealth& stream,
                double merged_resolution,
                MergedFrames frames)
{
  std::vector<std::string> faults;
  const auto add = [&](std::size_t in_last, std::size_t merges, const char* fault) {
    if (frames == MergedFrames::Last && in_last > 0)
      faults.emplace_back(fault);
    if (frames == MergedFrames::All && merges > 0)
      faults.push_back(fault + std::string(": in ") + std::to_string(merges) +
                       (merges == 1 ? " merged frame" : " merged frames"));
  };
  add(stream.voxels_outside_grid,
      stream.merges_outside_grid,
      "Voxels are too far from those of other streams to be merged");
  add(stream.intensities_reduced,
      stream.merges_reduced,
      "Intensities are too far above those of other streams to be merged");
  if (leavesGaps(stream, merged_resolution))
    faults.push_back(gapsOf(stream, merged_resolution));
  return faults;
}

void
HealthReport::raise(HealthLevel level, const std::string& message)
{
  // An error is said, too, where nothing has arrived yet.
  const auto severity = [](HealthLevel of) {
    return of == HealthLevel::Error ? 4 : static_cast<int>(of);
  };
  if (severity(level) <= severity(level_))
    return;
  level_ = level;
  message_ = message;
}

HealthReport
describeHealth(const SenderHealth& now, const SenderHealth& before, Time time)
{
  HealthReport report;
  const SensorNodeStatistics& node = now.node;
  const auto old_transforms = [](const SenderHealth& health) {
    return health.node.frames_with_last_transform + health.latest_transforms;
  };
  checkArrival("clouds", now.last_arrival, time, report);
  if (now.cloudsWithoutTransform() > before.cloudsWithoutTransform())
    report.raise(HealthLevel::Error, "Clouds without transform are dropped");
  if (now.clouds_missed > before.clouds_missed)
    report.raise(HealthLevel::Warning,
                 "Clouds are missing: lost on the way or dropped from the queue");
  if (node.clouds_refused > before.node.clouds_refused)
    report.raise(HealthLevel::Error, "Clouds are refused");
  if (node.frame.voxelization.points_outside_grid > 0)
    report.raise(HealthLevel::Warning,
                 "Points are left out, as they are outside the grid of voxels");
  if (node.outliers_stay)
    report.raise(HealthLevel::Warning,
                 "Outliers stay, as voxels of this edge are not judged");
  if (node.outliers_removed > node.frame.coding.voxels)
    report.raise(HealthLevel::Warning, "Most voxels are removed as outliers");
  if (node.points_removed > node.frame.voxelization.points_used)
    report.raise(HealthLevel::Warning, "Most points are removed as outliers");
  if (old_transforms(now) > old_transforms(before))
    report.raise(HealthLevel::Warning, "A transform of another time is used");
  if (!node.rate_control.not_kept.empty())
    report.raise(HealthLevel::Warning, "Rate control: " + node.rate_control.not_kept);
  else if (node.rate_control.clouds_left_out > before.node.rate_control.clouds_left_out)
    report.raise(HealthLevel::Warning, "Clouds are left out, as max_rate has no room");

  addRates(node.rates, report);
  report.add("compression ratio", node.compressionRatio());
  report.add("clouds", now.clouds);
  report.add("clouds missed", now.clouds_missed);
  report.add("frames", node.frames);
  report.add("I-frames", node.i_frames);
  report.add("I-frame requests", now.i_frame_requests);
  report.add("frames with last transform", old_transforms(now));
  report.add("clouds without transform", now.cloudsWithoutTransform());
  report.add("clouds refused", node.clouds_refused);
  report.add("points", node.preprocessing.points);
  report.add("points cropped", node.preprocessing.points_cropped);
  report.add("points not finite", node.preprocessing.points_not_finite);
  report.add("points outside the grid", node.frame.voxelization.points_outside_grid);
  report.add("outliers removed", node.outliers_removed);
  report.add("points removed as outliers", node.points_removed);
  const bool has_points = node.frame.coding.has_points;
  report.add(has_points ? "points in order" : "voxels", node.frame.coding.voxels);
  report.add(has_points ? "bytes per point" : "bytes per voxel",
             node.frame.bytesPerVoxel());
  if (node.rate_control.is_on) {
    report.add("rate control", node.rate_control.choice);
    report.add("rate control chose it as", node.rate_control.reason);
    report.add("rate control step", node.rate_control.step_number);
    report.add("max_rate, bit/s", node.rate_control.max_rate);
    report.add("bits of the last second", node.rate_control.used_rate);
    report.add("clouds left out for max_rate", node.rate_control.clouds_left_out);
  }
  return report;
}

HealthReport
describeHealth(const ReceiverHealth& now, const ReceiverHealth& before, Time time)
{
  HealthReport report;
  checkArrival("frames", now.last_arrival, time, report);
  judge(now, before, report);
  const StreamHealth& stream = now.stream;
  addRates(stream.rates, report);
  report.add("compression ratio", compressionRatio(stream));
  report.add("frames received", stream.frames_received);
  report.add("frames decoded", stream.frames_decoded);
  report.add("frames failed", stream.frames_failed);
  report.add("frames dropped", stream.frames_dropped);
  report.add("frames refused", stream.frames_refused);
  report.add("frames lost", stream.frames_lost);
  report.add("frames of other frame id or format", now.left_out);
  report.add("I-frame requests", stream.i_frame_requests);
  report.add("voxels", stream.voxels);
  report.add("kept voxels", stream.kept_voxels);
  report.add("outliers removed", stream.outliers_removed);
  report.add("outlier removal", stream.outlier_removal.message());
  report.add("points outside the grid", stream.points_outside_grid);
  report.add("voxels outside merged grid", stream.voxels_outside_grid);
  report.add("intensities reduced in merged grid", stream.intensities_reduced);
  report.add("resolution, m", stream.resolution);
  report.add("min_intensity", now.min_intensity);
  report.add("memory drops", stream.memory_drops);
  report.add("in sync", stream.in_sync ? "yes" : "no");
  return report;
}

HealthReport
describeTogether(const std::vector<StreamHealth>& streams,
                 bool are_ok,
                 std::size_t map_nodes,
                 Time time)
{
  HealthReport report;
  double frames_per_second = 0.0;
  double bytes_per_second = 0.0;
  std::size_t in_sync = 0;
  std::size_t silent = 0;
  for (const StreamHealth& stream : streams) {
    frames_per_second += stream.rates.frames_per_second;
    bytes_per_second += stream.rates.bytes_per_second;
    in_sync += stream.in_sync ? 1 : 0;
    silent +=
        stream.frames_decoded == 0 || time - stream.last_decoded > silence ? 1 : 0;
  }
  if (!are_ok)
    report.raise(HealthLevel::Warning, "Not all streams are OK");
  report.add("streams", streams.size());
  report.add("streams in sync", in_sync);
  report.add("streams without frames for 2 s", silent);
  report.add("frames per second", frames_per_second);
  report.add("bytes per second", bytes_per_second);
  report.add("map nodes", map_nodes);
  return report;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
