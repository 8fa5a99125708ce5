#include "parameter_tables.h"

#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/nodes/central_node.h>

#include <cstdint>

namespace pcl_ext_ros {

namespace {

using pcl_ext::nodes::ParameterDescription;
using pcl_ext::nodes::ParameterValue;

ParameterDescription
describe(const std::string& name,
         const std::string& unit,
         const ParameterValue& default_value,
         const std::string& description)
{
  ParameterDescription parameter;
  parameter.name = name;
  parameter.unit = unit;
  parameter.default_value = default_value;
  parameter.description = description + " Read at the start.";
  return parameter;
}

ParameterDescription
describe(const std::string& name,
         const std::string& unit,
         const ParameterValue& default_value,
         double lowest,
         double highest,
         const std::string& description)
{
  ParameterDescription parameter = describe(name, unit, default_value, description);
  parameter.lowest = lowest;
  parameter.highest = highest;
  return parameter;
}

constexpr double largest_integer = 2147483647;

} // namespace

const Descriptions&
sensorNodeParameters()
{
  static const Descriptions parameters = {
      describe("global_frame", "", std::string("world"), "TF frame of the voxels."),
      describe("tf_timeout",
               "s",
               0.05,
               0,
               10,
               "Time after a cloud's stamp for which its transform is waited for."),
      describe("queue_size",
               "clouds",
               std::int64_t{5},
               1,
               1000,
               "Clouds that can wait, for the processor or for their transform; the "
               "oldest are dropped.")};
  return parameters;
}

const Descriptions&
centralNodeParameters()
{
  using pcl_ext::io::largest_resolution;
  using pcl_ext::io::smallest_resolution;
  constexpr double largest_intensity = 3.4e38; // below the largest float
  const std::string none;
  const pcl_ext::nodes::CentralNodeSettings defaults;
  static const Descriptions parameters = {
      describe("global_frame",
               "",
               std::string("world"),
               "Frames with another frame_id are reported and dropped."),
      describe("resolution",
               "m",
               defaults.resolution,
               smallest_resolution,
               largest_resolution,
               "Edge of the voxels of the merged grid and of the map."),
      describe("merge_rate", "Hz", 10.0, 0, 1000, "Rate of ~/merged; 0: no merging."),
      describe("max_merge_age",
               "s",
               std::chrono::duration<double>(defaults.max_merge_age).count(),
               0.001,
               3600,
               "Older frames are not merged."),
      describe("threads",
               "",
               std::int64_t{defaults.threads},
               0,
               1024,
               "Threads that decode; 0: one for each core."),
      describe("max_waiting_frames",
               "frames",
               static_cast<std::int64_t>(defaults.max_waiting_frames),
               1,
               100000,
               "Frames of one stream that can wait; more are refused."),
      describe(
          "map_path",
          "",
          none,
          "File for the OctoMap (.ot), written by ~/write_map and at the end unless "
          "it is empty; an existing file is replaced; '': none."),
      describe("map_rate", "Hz", 1.0, 0.001, 1000, "Updates of the map."),
      describe(
          "map_full_intensity",
          "of the intensity",
          4.0,
          1e-6,
          largest_intensity,
          "A voxel of this intensity, or without one, counts as one hit in the map, "
          "others as a part of one; 255 is a full face for quadratic and linear."),
      describe("view_port",
               "",
               std::int64_t{0},
               0,
               65535,
               "Port on which browsers look at the streams, with all noise; 0: none."),
      describe(
          "view_address",
          "",
          none,
          "Address in numbers on which others are served, such as 0.0.0.0: whoever "
          "reaches it sees the clouds; '': this machine alone."),
      describe("view_page",
               "",
               none,
               "File of the viewer's page, viewer.html; '': the installed one.")};
  return parameters;
}

const Descriptions&
streamParameters()
{
  static const Descriptions parameters = {
      describe("sensor_frame",
               "",
               std::string(),
               "TF frame of the sensor, from which the map takes rays to the voxels; "
               "'': none.")};
  return parameters;
}

const Descriptions&
cellParameters()
{
  static const Descriptions parameters = {
      describe("sensors",
               "",
               std::vector<double>{1, 2, 3, 4, 5, 6},
               1,
               6,
               "Numbers of the sensors."),
      describe("rate", "Hz", 20.0, 0.01, 1000, "Clouds per second of each sensor."),
      describe("seed",
               "",
               std::int64_t{1},
               0,
               largest_integer,
               "Seed of the simulated errors."),
      describe("frames",
               "frames",
               std::int64_t{0},
               0,
               largest_integer,
               "Frames to send; 0: no limit."),
      describe(
          "captured_frames",
          "frames",
          std::int64_t{0},
          0,
          300,
          "Frames that are captured before the start and repeated, 3.5 MB each and "
          "for each sensor; 0: each is captured when it is sent."),
      describe("wait_for_subscribers",
               "",
               false,
               "Start when the clouds of each sensor have a subscriber."),
      describe(
          "global_frame", "", std::string("world"), "Parent frame of the transforms.")};
  return parameters;
}

} // namespace pcl_ext_ros
