// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// What the ROS nodes use of the simulated robot cell: its parameters and a cloud.
#include <pcl_ext/version.h>

#include "simulator/cell_parameters.h"
#include "simulator/robot_cell.h"

#include <algorithm>
#include <cmath>
#include <iostream>

int
main()
{
  pcl_ext::cell::RobotCell cell;
  pcl_ext::cell::CellFrame frame;
  cell.capture(1, 0, frame);
  const auto points = std::count_if(frame.cloud.begin(),
                                    frame.cloud.end(),
                                    [](const auto& p) { return std::isfinite(p.z); });
  std::cout << "version " << pcl_ext::version() << ", " << points << " points, "
            << pcl_ext::cell::cellParameters().size() << " parameters\n";
  return points > 100000 ? 0 : 1;
}
