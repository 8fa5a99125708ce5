/** \file
 * \brief Runs the tests of a program as one ROS node, started by with_master.py.
 */
#include <gtest/gtest.h>

#include <ros/ros.h>

int
main(int argc, char** argv)
{
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc,
            argv,
            "ros_tests",
            ros::init_options::AnonymousName | ros::init_options::NoSigintHandler);
  if (!ros::master::check()) {
    ROS_FATAL("No ROS master; start this program by with_master.py");
    return 1;
  }
  int result = 1;
  {
    // ROS shuts down with the last handle; this one outlives all tests.
    const ros::NodeHandle node;
    ros::AsyncSpinner spinner(2);
    spinner.start();
    result = RUN_ALL_TESTS();
    spinner.stop();
  }
  ros::shutdown();
  return result;
}
