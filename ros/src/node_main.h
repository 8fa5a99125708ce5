// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/console.h>
#include <ros/init.h>
#include <ros/node_handle.h>

#include <exception>
#include <iostream>

namespace pcl_ext_ros1 {

/** \brief Runs a node until it is stopped.
 * \tparam NodeT has a default constructor, which reads the parameters, and run()
 * \param[in] argc,argv of main
 * \param[in] name default name of the node
 * \return the result of run(), or 1 after one line with the error
 */
template <typename NodeT>
int
runNode(int argc, char** argv, const char* name)
{
  try {
    ros::init(argc, argv, name);
  }
  catch (const std::exception& failure) {
    std::cerr << failure.what() << '\n';
    return 1;
  }
  // ROS shuts its console down with the last handle, which must outlive the node.
  const ros::NodeHandle handle;
  try {
    NodeT node;
    return node.run();
  }
  catch (const std::exception& failure) {
    ROS_FATAL("%s", failure.what());
    return 1;
  }
}

} // namespace pcl_ext_ros1
