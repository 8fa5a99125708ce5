#pragma once

#include <pcl_ext/nodes/sensor_node.h>

#include "compressor_parameters.h"
#include "health_report.h"
#include "transform_lookup.h"

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Empty.h>

#include <cstddef>
#include <string>

namespace pcl_ext_ros {

/** \brief The node beside a sensor: clouds in, compressed frames out. README.md tells its
 * topics and parameters. All of it happens in the thread of run(). */
class IntensityCompressor {
public:
  /** \brief Reads the parameters and connects.
   * \throws WrongParameter
   */
  IntensityCompressor();

  /** \brief Works until ROS shuts down. */
  int
  run();

private:
  /** \brief What the node itself counts, besides SensorNode. */
  struct Counts {
    std::size_t clouds = 0;                ///< received
    std::size_t clouds_missed = 0;         ///< gaps in the sender's numbers
    std::size_t latest_transforms = 0;     ///< none at the stamp, the latest was used
    std::size_t clouds_of_other_frame = 0; ///< left out: another frame, unknown to TF
    std::size_t i_frame_requests = 0;      ///< received
  };

  void
  compress(const sensor_msgs::PointCloud2::Ptr& cloud);

  /** \brief Counts clouds that were dropped before this one: on the way, or as the queue
   * was full. */
  void
  countMissed(std::uint32_t number);

  /** \brief Tells the sensor node of a request, unless it was told of one for the last
   * frame: two I-frames in a row help nobody. */
  void
  passOnIFrameRequest();

  void
  receiveRequest(const std_msgs::Empty&);

  void
  reportHealth(const ros::WallTimerEvent&);

  HealthReport
  describeHealth(const pcl_ext::nodes::SensorNodeStatistics& now) const;

  ros::NodeHandle node_;
  CompressorParameters parameters_;
  pcl_ext::nodes::SensorNode sensor_node_;
  TransformLookup transforms_;
  std::string frame_of_last_transform_;

  bool i_frame_is_wanted_ = false;
  std::size_t frames_since_request_ = 2; // passed on

  std::string input_topic_;
  ros::WallTime last_arrival_;
  std::uint32_t last_number_ = 0; // of the last cloud, by its sender
  Counts counts_;
  Counts reported_counts_; // as of the last report
  pcl_ext::nodes::SensorNodeStatistics reported_statistics_;

  ros::Publisher frames_;
  ros::Publisher diagnostics_;
  ros::Subscriber requests_;
  ros::Subscriber clouds_;
  ros::WallTimer report_timer_;
};

} // namespace pcl_ext_ros
