#pragma once

#include <pcl_ext/nodes/node_parameters.h>

#include <string>
#include <vector>

// The parameters of the nodes besides encodingParameters() and noiseParameters().

namespace pcl_ext_ros {

using Descriptions = std::vector<pcl_ext::nodes::ParameterDescription>;

/** \brief Of SensorNode. All are read at the start. */
const Descriptions&
sensorNodeParameters();

/** \brief Of CentralNode, except for `streams`. All are read at the start. */
const Descriptions&
centralNodeParameters();

/** \brief What `streams` is for. */
inline constexpr const char* description_of_streams =
    "Topics of the streams. Read at the start.";

/** \brief Of one stream of CentralNode, besides noiseParameters(). Read at the start. */
const Descriptions&
streamParameters();

/** \brief Of SimulatedCell. All are read at the start. */
const Descriptions&
cellParameters();

/** \brief The value of a parameter, which is in `values`. */
template <typename ValueT>
const ValueT&
valueOf(const pcl_ext::nodes::ParameterValues& values, const std::string& name)
{
  return std::get<ValueT>(values.at(name));
}

/** \brief A frame id as tf2 needs it. */
inline std::string
withoutLeadingSlash(const std::string& frame_id)
{
  return !frame_id.empty() && frame_id.front() == '/' ? frame_id.substr(1) : frame_id;
}

} // namespace pcl_ext_ros
