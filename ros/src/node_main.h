#pragma once

#include "parameter_reader.h"

#include <ros/console.h>
#include <ros/init.h>
#include <ros/node_handle.h>

#include <exception>
#include <iostream>

namespace pcl_ext_ros {

/** \brief Runs a node until it is told to stop.
 * \tparam NodeT has a constructor without arguments, which reads the parameters, and run()
 * \param[in] argc,argv of main
 * \param[in] name of the node, unless it is given another
 * \return what run() returns, or 1 after one line that says what is wrong
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
  // With the last handle, which the node has otherwise, ROS shuts its console down.
  const ros::NodeHandle keeps_console;
  try {
    NodeT node;
    return node.run();
  }
  catch (const std::exception& failure) {
    ROS_FATAL("%s", failure.what());
    return 1;
  }
}

} // namespace pcl_ext_ros
