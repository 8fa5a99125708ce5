/** \file
 * \brief A source of clouds without a sensor: the simulated robot cell, in real time.
 */
#include "message_conversions.h"
#include "node_main.h"

#include <geometry_msgs/TransformStamped.h>
#include <pcl_conversions/pcl_conversions.h>
#include "simulator/robot_cell.h"
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace pcl_ext_ros {

namespace {

using pcl_ext::cell::RobotCell;

constexpr int most = std::numeric_limits<std::int32_t>::max();

/** \brief What README.md documents. */
struct CellParameters {
  std::vector<unsigned int> sensors;
  double rate = RobotCell::frame_rate;
  std::uint32_t seed = 1;
  std::uint32_t frames = 0;          ///< 0: no end
  std::uint32_t captured_frames = 0; ///< 0: each is captured when it is sent
  bool wait_for_subscribers = false;
  std::string global_frame;
};

std::vector<unsigned int>
readSensors(ParameterReader& reader)
{
  const auto elements = reader.list("sensors");
  if (!elements)
    return {1, 2, 3, 4, 5, 6};
  std::vector<unsigned int> sensors;
  for (XmlRpc::XmlRpcValue element : *elements) {
    const bool is_whole = element.getType() == XmlRpc::XmlRpcValue::TypeInt;
    const int sensor = is_whole ? static_cast<int>(element) : 0;
    if (sensor < 1 || sensor > static_cast<int>(RobotCell::sensor_count))
      ParameterReader::refuse("sensors",
                              toText(element) + " in one place",
                              "a list of numbers from 1 to 6");
    sensors.push_back(static_cast<unsigned int>(sensor));
  }
  if (sensors.empty())
    ParameterReader::refuse(
        "sensors", "an empty list", "a list of numbers from 1 to 6");
  return sensors;
}

CellParameters
readCellParameters()
{
  ParameterReader reader;
  CellParameters parameters;
  parameters.sensors = readSensors(reader);
  parameters.rate = reader.number("rate", RobotCell::frame_rate, 0.01, 1000);
  parameters.seed = static_cast<std::uint32_t>(reader.count("seed", 1, 0, most));
  parameters.frames = static_cast<std::uint32_t>(reader.count("frames", 0, 0, most));
  parameters.captured_frames =
      static_cast<std::uint32_t>(reader.count("captured_frames", 0, 0, 300));
  parameters.wait_for_subscribers = reader.flag("wait_for_subscribers", false);
  parameters.global_frame =
      withoutLeadingSlash(reader.nonEmptyText("global_frame", "world"));
  reader.refuseUnknownNames();
  return parameters;
}

} // namespace

/** \brief Sends the clouds of the cell's sensors, all with one stamp. */
class SimulatedCell {
public:
  SimulatedCell() : parameters_(readCellParameters()), cell_(parameters_.seed)
  {
    for (const unsigned int sensor : parameters_.sensors)
      clouds_.push_back(
          node_.advertise<sensor_msgs::PointCloud2>(frameOf(sensor) + "/points", 2));
    sendTransforms();
    for (std::uint32_t frame = 0; frame < parameters_.captured_frames; ++frame)
      for (const unsigned int sensor : parameters_.sensors)
        captured_.push_back(capture(sensor, frame));
  }

  int
  run()
  {
    ros::Rate rate(parameters_.rate);
    while (ros::ok() && parameters_.wait_for_subscribers && !everybodyListens()) {
      ros::spinOnce();
      ros::WallDuration(0.02).sleep();
    }
    for (std::uint32_t frame = 0;
         ros::ok() && (parameters_.frames == 0 || frame < parameters_.frames);
         ++frame) {
      send(frame);
      ros::spinOnce();
      rate.sleep();
    }
    // Who comes later still wants the transforms.
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
    for (const unsigned int sensor : parameters_.sensors) {
      geometry_msgs::TransformStamped transform =
          tf2::eigenToTransform(cell_.sensorPose(sensor));
      transform.header.stamp = ros::Time::now();
      transform.header.frame_id = parameters_.global_frame;
      transform.child_frame_id = frameOf(sensor);
      transforms.push_back(transform);
    }
    broadcaster_.sendTransform(transforms);
  }

  bool
  everybodyListens() const
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
      // Each cloud takes a few milliseconds and many megabytes.
      if (clouds_[i].getNumSubscribers() == 0)
        continue;
      if (parameters_.captured_frames == 0)
        publish(clouds_[i], capture(parameters_.sensors[i], frame), stamp);
      else
        publish(clouds_[i],
                captured_[frame % parameters_.captured_frames * clouds_.size() + i],
                stamp);
    }
  }

  static void
  publish(const ros::Publisher& publisher,
          const sensor_msgs::PointCloud2& captured,
          const ros::Time& stamp)
  {
    sensor_msgs::PointCloud2 cloud = captured;
    cloud.header.stamp = stamp;
    publisher.publish(cloud);
  }

  ros::NodeHandle node_;
  CellParameters parameters_;
  RobotCell cell_;
  pcl_ext::cell::CellFrame captured_frame_;
  std::vector<sensor_msgs::PointCloud2> captured_; // by frame, then by sensor
  std::vector<ros::Publisher> clouds_;             // as parameters_.sensors
  tf2_ros::StaticTransformBroadcaster broadcaster_;
};

} // namespace pcl_ext_ros

int
main(int argc, char** argv)
{
  return pcl_ext_ros::runNode<pcl_ext_ros::SimulatedCell>(argc, argv, "simulated_cell");
}
