// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/cell_parameters.h"

#include <pcl_ext/nodes/impl/cloud_messages.h>

#include "simulator/robot_cell.h"

#include <cmath>

namespace pcl_ext {
namespace cell {

namespace {

constexpr double largest_integer = 2147483647;

nodes::ParameterDescription
describe(const std::string& name,
         const std::string& unit,
         const nodes::ParameterValue& default_value,
         double lowest,
         double highest,
         const std::string& description)
{
  return {name, unit, default_value, lowest, highest, 0, {}, description};
}

nodes::ParameterDescription
describe(const std::string& name,
         const nodes::ParameterValue& default_value,
         const std::string& description)
{
  nodes::ParameterDescription parameter;
  parameter.name = name;
  parameter.default_value = default_value;
  parameter.description = description;
  return parameter;
}

} // namespace

const std::vector<nodes::ParameterDescription>&
cellParameters()
{
  const auto whole = [](std::int64_t number) { return nodes::ParameterValue(number); };
  static const std::vector<nodes::ParameterDescription> parameters = {
      describe("sensors",
               "",
               std::vector<double>{1, 2, 3, 4, 5, 6},
               1,
               RobotCell::sensor_count,
               "Numbers of the sensors, of the paper's table 1."),
      describe("rate",
               "Hz",
               RobotCell::frame_rate,
               0.01,
               1000,
               "Clouds per second of each sensor."),
      describe("seed", "", whole(1), 0, largest_integer, "Seed of the errors."),
      describe("frames",
               "frames",
               whole(0),
               0,
               largest_integer,
               "Frames to send; 0: no limit."),
      describe(
          "captured_frames",
          "frames",
          whole(0),
          0,
          300,
          "Frames that are captured before the start and repeated, 3.5 MB each and "
          "for each sensor; 0: each is captured when it is sent."),
      describe("wait_for_subscribers",
               false,
               "Start when the clouds of each sensor have a subscriber."),
      describe(
          "global_frame", std::string("world"), "Parent frame of the transforms.")};
  return parameters;
}

CellSettings
readCellParameters(const nodes::ParameterValues& values)
{
  const auto count = [&values](const std::string& name) {
    return static_cast<std::uint32_t>(nodes::valueOf<std::int64_t>(values, name));
  };
  CellSettings settings;
  for (const double sensor : nodes::valueOf<std::vector<double>>(values, "sensors"))
    settings.sensors.push_back(static_cast<unsigned int>(std::lround(sensor)));
  settings.rate = nodes::valueOf<double>(values, "rate");
  settings.seed = count("seed");
  settings.frames = count("frames");
  settings.captured_frames = count("captured_frames");
  settings.waits_for_subscribers = nodes::valueOf<bool>(values, "wait_for_subscribers");
  settings.global_frame =
      nodes::withoutLeadingSlash(nodes::valueOf<std::string>(values, "global_frame"));
  return settings;
}

} // namespace cell
} // namespace pcl_ext
