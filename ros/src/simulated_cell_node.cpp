/** \file
 * \brief Sends the clouds of the simulated robot cell in real time.
 */
#include "node_main.h"
#include "parameter_reader.h"
#include "simulator/cell_parameters.h"
#include "simulator/robot_cell.h"

#include <geometry_msgs/TransformStamped.h>
#include <pcl_conversions/pcl_conversions.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext_ros1 {

namespace {

pcl_ext::cell::CellSettings
readSettings()
{
  ParameterReader reader;
  const auto values = reader.values(pcl_ext::cell::cellParameters());
  reader.refuseUnknownNames();
  const auto settings = pcl_ext::cell::readCellParameters(values);
  if (settings.sensors.empty())
    ParameterReader::refuse("sensors", "an empty list", "a list of numbers");
  return settings;
}

} // namespace

/** \brief Sends the clouds of all sensors of a frame with the same stamp. */
class SimulatedCell {
public:
  SimulatedCell() : settings_(readSettings()), cell_(settings_.seed)
  {
    for (const unsigned int sensor : settings_.sensors)
      clouds_.push_back(
          node_.advertise<sensor_msgs::PointCloud2>(frameOf(sensor) + "/points", 2));
    sendTransforms();
    for (std::uint32_t frame = 0; frame < settings_.captured_frames; ++frame)
      for (const unsigned int sensor : settings_.sensors)
        captured_.push_back(capture(sensor, frame));
  }

  int
  run()
  {
    ros::Rate rate(settings_.rate);
    while (ros::ok() && settings_.waits_for_subscribers && !allHaveSubscribers()) {
      ros::spinOnce();
      ros::WallDuration(0.02).sleep();
    }
    for (std::uint32_t frame = 0;
         ros::ok() && (settings_.frames == 0 || frame < settings_.frames);
         ++frame) {
      send(frame);
      ros::spinOnce();
      rate.sleep();
    }
    // Later subscribers need the transforms.
    ros::spin();
    return 0;
  }

private:
  static std::string
  frameOf(unsigned int sensor)
  {
    return "kinect_" + std::to_string(sensor);
  }

  void
  sendTransforms()
  {
    std::vector<geometry_msgs::TransformStamped> transforms;
    for (const unsigned int sensor : settings_.sensors) {
      geometry_msgs::TransformStamped transform =
          tf2::eigenToTransform(cell_.sensorPose(sensor));
      transform.header.stamp = ros::Time::now();
      transform.header.frame_id = settings_.global_frame;
      transform.child_frame_id = frameOf(sensor);
      transforms.push_back(transform);
    }
    broadcaster_.sendTransform(transforms);
  }

  bool
  allHaveSubscribers() const
  {
    for (const ros::Publisher& publisher : clouds_)
      if (publisher.getNumSubscribers() == 0)
        return false;
    return true;
  }

  sensor_msgs::PointCloud2
  capture(unsigned int sensor, std::uint32_t frame)
  {
    cell_.capture(sensor, frame, captured_frame_);
    pcl::PCLPointCloud2 cloud;
    pcl::toPCLPointCloud2(captured_frame_.cloud, cloud);
    sensor_msgs::PointCloud2 message;
    pcl_conversions::moveFromPCL(cloud, message);
    message.header.frame_id = frameOf(sensor);
    return message;
  }

  void
  send(std::uint32_t frame)
  {
    const ros::Time stamp = ros::Time::now();
    for (std::size_t i = 0; i < clouds_.size(); ++i) {
      // Capturing takes milliseconds, and a cloud has megabytes.
      if (clouds_[i].getNumSubscribers() == 0)
        continue;
      sensor_msgs::PointCloud2 cloud;
      if (settings_.captured_frames == 0)
        cloud = capture(settings_.sensors[i], frame);
      else
        cloud = captured_[frame % settings_.captured_frames * clouds_.size() + i];
      cloud.header.stamp = stamp;
      clouds_[i].publish(cloud);
    }
  }

  ros::NodeHandle node_;
  pcl_ext::cell::CellSettings settings_;
  pcl_ext::cell::RobotCell cell_;
  pcl_ext::cell::CellFrame captured_frame_;
  std::vector<sensor_msgs::PointCloud2> captured_; // by frame, then by sensor
  std::vector<ros::Publisher> clouds_;             // as settings_.sensors
  tf2_ros::StaticTransformBroadcaster broadcaster_;
};

} // namespace pcl_ext_ros1

int
main(int argc, char** argv)
{
  return pcl_ext_ros1::runNode<pcl_ext_ros1::SimulatedCell>(
      argc, argv, "simulated_cell");
}
