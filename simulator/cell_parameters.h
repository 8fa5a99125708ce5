// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The parameters of the ROS nodes that send the clouds of the robot cell.
 */
#pragma once

#include <pcl_ext/nodes/impl/node_parameters.h>

#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext {
namespace cell {

/** \brief The parameters of a simulated_cell. All are read at the start. */
const std::vector<nodes::ParameterDescription>&
cellParameters();

/** \brief What cellParameters() say. */
struct CellSettings {
  std::vector<unsigned int> sensors;
  double rate = 0.0; ///< clouds per second of each sensor
  std::uint32_t seed = 0;
  std::uint32_t frames = 0;          ///< 0: no limit
  std::uint32_t captured_frames = 0; ///< 0: each frame is captured when it is sent
  bool waits_for_subscribers = false;
  std::string global_frame; ///< without a leading slash
};

/** \brief The settings of a simulated_cell.
 * \param[in] values of all cellParameters(), each as convertedValue() returns it
 */
CellSettings
readCellParameters(const nodes::ParameterValues& values);

} // namespace cell
} // namespace pcl_ext
