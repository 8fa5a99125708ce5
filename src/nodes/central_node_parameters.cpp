// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/nodes/impl/merging_centre.h>
#include <pcl_ext/nodes/impl/node_parameters.h>

#include "nodes/parameter_access.h"

#include <algorithm>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

using Descriptions = std::vector<ParameterDescription>;

ParameterDescription
frameParameter(const std::string& description)
{
  return textParameter("global_frame", SensorNodeSettings().global_frame, description);
}

void
describeMerging(Descriptions& parameters)
{
  const CentralNodeSettings defaults;
  const MergeScheduleSettings schedule;
  using Seconds = std::chrono::duration<double>;
  parameters.push_back(frameParameter("TF frame that frames have to be in; others are "
                                      "reported and dropped."));
  parameters.push_back(
      numberParameter("resolution",
                      "m",
                      defaults.resolution,
                      io::smallest_resolution,
                      io::largest_resolution,
                      "Edge of the voxels of the merged grid and of the map."));
  parameters.push_back(numberParameter(
      "merge_rate", "Hz", 10.0, 0, 1000, "Rate of merged clouds; 0: no merging."));
  parameters.push_back(numberParameter(
      "merge_wait",
      "s",
      Seconds(schedule.max_wait).count(),
      0,
      3600,
      "Time for which a merged cloud waits for streams that are behind others."));
  parameters.push_back(numberParameter(
      "max_merge_age",
      "s",
      Seconds(schedule.max_age).count(),
      0.001,
      3600,
      "Older frames are not merged, nor waited for; longer than from one "
      "cloud of the slowest sensor to the next."));
  parameters.push_back(countParameter("threads",
                                      "",
                                      defaults.threads,
                                      0,
                                      1024,
                                      "Threads that decode; 0: one for each core."));
  parameters.push_back(
      countParameter("max_waiting_frames",
                     "frames",
                     static_cast<std::uint32_t>(defaults.max_waiting_frames),
                     1,
                     100000,
                     "Frames of one stream that can wait; more are refused."));
}

void
describeMap(Descriptions& parameters)
{
  parameters.push_back(textParameter(
      "map_path",
      "",
      "File for the OctoMap (.ot), written on request and, unless the map is empty, at "
      "the end; an existing file is replaced; '': none."));
  parameters.push_back(
      numberParameter("map_rate", "Hz", 1.0, 0.001, 1000, "Updates of the map."));
  parameters.push_back(numberParameter(
      "map_full_intensity",
      "of the intensity",
      4.0,
      1e-6,
      largest_intensity,
      "A voxel of this intensity, or without one, counts as one hit in the map, others "
      "as a part of one; 255 is a full face for quadratic and linear."));
}

void
describeView(Descriptions& parameters)
{
  constexpr std::int32_t largest_port = 65535;
  parameters.push_back(countParameter(
      "view_port",
      "",
      0,
      0,
      largest_port,
      "Port on which browsers look at the streams, with all noise; 0: none."));
  parameters.push_back(textParameter(
      "view_address",
      "",
      "Address in numbers on which others are served, such as 0.0.0.0: whoever reaches "
      "it sees the clouds; '': this machine alone."));
  parameters.push_back(
      textParameter("view_page",
                    "",
                    "File of the viewer's page, viewer.html; '': the installed one."));
}

Descriptions
describeCentralNodeParameters()
{
  Descriptions parameters;
  describeMerging(parameters);
  describeMap(parameters);
  describeView(parameters);
  return parameters;
}

} // namespace

const Descriptions&
sensorNodeParameters()
{
  static const Descriptions parameters = {
      frameParameter("TF frame of the voxels."),
      numberParameter(
          "tf_timeout",
          "s",
          0.05,
          0,
          10,
          "Time after a cloud's stamp for which its transform is waited for."),
      countParameter("queue_size",
                     "clouds",
                     5,
                     1,
                     1000,
                     "Clouds that can wait, for the processor or for their transform; "
                     "the oldest are dropped.")};
  return parameters;
}

const Descriptions&
centralNodeParameters()
{
  static const Descriptions parameters = describeCentralNodeParameters();
  return parameters;
}

const Descriptions&
streamParameters()
{
  static const Descriptions parameters = {
      textParameter("sensor_frame",
                    "",
                    "TF frame of the sensor, from which the map takes rays to the "
                    "voxels; '': none.")};
  return parameters;
}

MergingCentreSettings
readCentralNodeParameters(const ParameterValues& values, Clock clock)
{
  const ParameterAccess access(centralNodeParameters(), values);
  const auto toTime = [](double seconds) {
    return std::chrono::duration_cast<Time>(std::chrono::duration<double>(seconds));
  };
  MergingCentreSettings settings;
  settings.node.resolution = access.get<double>("resolution");
  settings.node.threads = access.count("threads");
  settings.node.max_waiting_frames = access.count("max_waiting_frames");
  settings.node.max_merge_age = toTime(access.get<double>("max_merge_age"));
  settings.node.clock = std::move(clock);
  settings.schedule.max_age = settings.node.max_merge_age;
  settings.schedule.max_wait = toTime(access.get<double>("merge_wait"));
  const double rate = access.get<double>("merge_rate");
  settings.reports_resolution = rate > 0.0;
  constexpr double longest_period = 3600.0; // seconds
  if (rate > 0.0)
    settings.schedule.period = toTime(std::min(1.0 / rate, longest_period));
  return settings;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
