// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The central node: compressed frames of many streams in, denoised voxels of each
 * stream out.
 */
#include <pcl_ext/nodes/impl/cloud_messages.h>
#include <pcl_ext/nodes/impl/merging_centre.h>

#include "message_conversions.h"
#include "node_main.h"
#include "parameter_reader.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <pcl_ext_ros1/CompressedPointCloud2.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Empty.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext_ros1 {

namespace {

using pcl_ext::nodes::ParameterValues;
using pcl_ext::nodes::valueOf;

/** \brief The parameters of a central node that this node has: it does not merge. */
std::vector<pcl_ext::nodes::ParameterDescription>
centralParameters()
{
  std::vector<pcl_ext::nodes::ParameterDescription> parameters;
  for (const char* const name : {"global_frame", "threads", "max_waiting_frames"})
    parameters.push_back(descriptionOf(pcl_ext::nodes::centralNodeParameters(), name));
  return parameters;
}

struct DecompressorParameters {
  ParameterValues node;            ///< of centralParameters()
  ParameterValues noise;           ///< of noiseParameters(), for all streams
  std::vector<std::string> topics; ///< as given, not resolved
};

/** \brief Reads the parameters and checks them.
 * \throws WrongParameter
 */
DecompressorParameters
readParameters()
{
  ParameterReader reader;
  DecompressorParameters parameters;
  parameters.node = reader.values(centralParameters());
  parameters.noise = reader.values(pcl_ext::nodes::noiseParameters());
  parameters.topics =
      reader.topics("streams").value_or(std::vector<std::string>{"input"});
  reader.refuseUnknownNames();
  return parameters;
}

struct Stream {
  ros::Publisher voxels;
  ros::Publisher i_frame_requests;
  ros::Subscriber frames;
};

} // namespace

/** \brief Decompresses and denoises streams. doc/nodes.md has the topics and
 * parameters. */
class IntensityDecompressor {
public:
  /** \brief Reads the parameters and connects.
   * \throws WrongParameter
   */
  IntensityDecompressor()
  {
    auto settings =
        pcl_ext::nodes::readCentralNodeParameters(parameters_.node, rosTimeNow);
    settings.reports_resolution = false; // as streams are not merged
    centre_.emplace(
        settings,
        [this](const pcl_ext::nodes::ReceivedFrame& frame) { publishFrame(frame); },
        pcl_ext::nodes::MergeListener());
    centre_->setNoise(parameters_.noise);
    diagnostics_ =
        node_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 10);
    for (const std::string& topic : parameters_.topics)
      addStream(node_.resolveName(topic));
    // Frames arrive from here on, when streams_ does not change any more.
    for (auto& [topic, stream] : streams_)
      subscribe(topic, stream);
    // A wall timer runs while simulated time stands still, too.
    report_timer_ = node_.createWallTimer(
        ros::WallDuration(1.0), &IntensityDecompressor::reportHealth, this);
  }

  int
  run()
  {
    ros::spin();
    return 0;
  }

private:
  void
  addStream(const std::string& topic)
  {
    if (!centre_->addStream(topic).ok())
      throw WrongParameter("Parameter ~streams has " + topic +
                           " twice; it must be a list of different topics");
    Stream& stream = streams_[topic];
    stream.voxels = node_.advertise<sensor_msgs::PointCloud2>(topic + "/voxels", 10);
    stream.i_frame_requests =
        node_.advertise<std_msgs::Empty>(topic + "/request_i_frame", 10);
  }

  void
  subscribe(const std::string& topic, Stream& stream)
  {
    const boost::function<void(const CompressedPointCloud2::ConstPtr&)> callback =
        [this, topic](const CompressedPointCloud2::ConstPtr& message) {
          receive(topic, *message);
        };
    stream.frames = node_.subscribe<CompressedPointCloud2>(
        topic, 40, callback, ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
    ROS_INFO("Decompressing %s", topic.c_str());
  }

  /** \brief Passes a frame on if it is in the global frame. */
  void
  receive(const std::string& topic, const CompressedPointCloud2& message)
  {
    if (const std::string fault =
            pcl_ext::nodes::faultOfMessage(message, global_frame_);
        !fault.empty()) {
      centre_->countLeftOut(topic);
      ROS_WARN_THROTTLE(seconds_between_warnings,
                        "A frame of %s is dropped: %s",
                        topic.c_str(),
                        fault.c_str());
      return;
    }
    const auto status = centre_->receive(
        topic, message.compressed_data, toNodeTime(message.header.stamp));
    if (!status.ok())
      ROS_WARN_THROTTLE(seconds_between_warnings, "%s", status.message().c_str());
  }

  /** \brief The centre's listener, which its threads call. */
  void
  publishFrame(const pcl_ext::nodes::ReceivedFrame& frame)
  {
    const Stream& stream = streams_.at(frame.stream);
    if (frame.wants_i_frame)
      stream.i_frame_requests.publish(std_msgs::Empty());
    if (!frame.status.ok()) {
      ROS_WARN_THROTTLE(seconds_between_warnings,
                        "A frame of %s is not decoded: %s",
                        frame.stream.c_str(),
                        frame.status.message().c_str());
      return;
    }
    if (frame.status.hasWarning())
      ROS_WARN_THROTTLE(seconds_between_warnings,
                        "A frame of %s: %s",
                        frame.stream.c_str(),
                        frame.status.message().c_str());
    if (stream.voxels.getNumSubscribers() == 0)
      return;
    sensor_msgs::PointCloud2 voxels;
    voxels.header.stamp = toRosTime(frame.stamp);
    voxels.header.frame_id = global_frame_;
    pcl_ext::nodes::writeVoxels(frame.voxels(), voxels);
    stream.voxels.publish(voxels);
  }

  void
  reportHealth(const ros::WallTimerEvent&)
  {
    diagnostic_msgs::DiagnosticArray message;
    message.header.stamp = ros::Time::now();
    for (const auto& [name, report] : centre_->describeHealth(0))
      message.status.push_back(toMessage(name, report));
    diagnostics_.publish(message);
  }

  ros::NodeHandle node_;
  const DecompressorParameters parameters_ = readParameters();
  const std::string global_frame_ = pcl_ext::nodes::withoutLeadingSlash(
      valueOf<std::string>(parameters_.node, "global_frame"));
  std::map<std::string, Stream> streams_; // by resolved topic
  ros::Publisher diagnostics_;
  ros::WallTimer report_timer_;

  // Last member, as its threads call publishFrame() until it is destroyed.
  std::optional<pcl_ext::nodes::MergingCentre> centre_;
};

} // namespace pcl_ext_ros1

int
main(int argc, char** argv)
{
  return pcl_ext_ros1::runNode<pcl_ext_ros1::IntensityDecompressor>(
      argc, argv, "intensity_decompressor");
}
