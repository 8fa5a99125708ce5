// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The node of a sensor: clouds in, compressed frames out.
 */
#include <pcl_ext/nodes/impl/cloud_messages.h>
#include <pcl_ext/nodes/impl/cloud_sender.h>

#include "message_conversions.h"
#include "node_main.h"
#include "parameter_reader.h"
#include "transform_lookup.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <pcl_ext_ros1/CompressedPointCloud2.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Empty.h>

#include <cstdint>
#include <optional>
#include <string>

namespace pcl_ext_ros1 {

using pcl_ext::nodes::SenderHealth;
using pcl_ext::nodes::SensorNodeCode;
using pcl_ext::nodes::valueOf;

namespace {

struct CompressorParameters {
  pcl_ext::nodes::ParameterValues encoding; ///< of encodingParameters()
  pcl_ext::nodes::ParameterValues node;     ///< of sensorNodeParameters()
};

/** \brief Reads the parameters and checks them one by one.
 * \throws WrongParameter
 */
CompressorParameters
readParameters()
{
  ParameterReader reader;
  CompressorParameters parameters;
  parameters.encoding = reader.values(pcl_ext::nodes::encodingParameters());
  parameters.node = reader.values(pcl_ext::nodes::sensorNodeParameters());
  reader.refuseUnknownNames();
  return parameters;
}

pcl_ext::nodes::SensorNodeSettings
settingsIn(const std::string& global_frame)
{
  pcl_ext::nodes::SensorNodeSettings settings;
  settings.global_frame = global_frame;
  settings.clock = rosTimeNow;
  return settings;
}

} // namespace

/** \brief Compresses the clouds of one sensor. doc/nodes.md has the topics and
 * parameters. All callbacks run in the thread of run(). */
class IntensityCompressor {
public:
  /** \brief Reads the parameters and connects.
   * \throws WrongParameter
   */
  IntensityCompressor()
  : sender_(settingsIn(global_frame_))
  , transforms_(global_frame_, valueOf<double>(parameters_.node, "tf_timeout"))
  {
    if (const std::string fault = sender_.setParameters(parameters_.encoding);
        !fault.empty())
      throw WrongParameter("Parameter ~" + fault);
    const std::string output_topic = node_.resolveName(input_topic_ + "/pcl_ext");
    frames_ = node_.advertise<CompressedPointCloud2>(output_topic, 40);
    diagnostics_ =
        node_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 10);
    requests_ = node_.subscribe(output_topic + "/request_i_frame",
                                10,
                                &IntensityCompressor::receiveRequest,
                                this);
    clouds_ = node_.subscribe(input_topic_,
                              static_cast<std::uint32_t>(valueOf<std::int64_t>(
                                  parameters_.node, "queue_size")),
                              &IntensityCompressor::compress,
                              this,
                              ros::TransportHints().tcpNoDelay());
    // A wall timer runs while simulated time stands still, too.
    report_timer_ = node_.createWallTimer(
        ros::WallDuration(1.0), &IntensityCompressor::reportHealth, this);
    ROS_INFO("Compressing %s to %s", input_topic_.c_str(), output_topic.c_str());
  }

  int
  run()
  {
    ros::spin();
    return 0;
  }

private:
  void
  compress(const sensor_msgs::PointCloud2::Ptr& cloud)
  {
    countMissed(cloud->header.seq);
    std_msgs::Header header = cloud->header;
    const pcl_ext::nodes::FoundTransform transform = transforms_.toGlobalFrame(header);
    if (transform.is_latest) {
      sender_.countLatestTransform();
      ROS_WARN_THROTTLE(
          seconds_between_warnings,
          "The latest transform is used, as there is none at the stamp: %s",
          transform.failure.c_str());
    }
    pcl::PCLPointCloud2 input;
    pcl_ext::nodes::moveToPcl(*cloud, input);
    input.header.stamp = header.stamp.toNSec() / 1000;
    CompressedPointCloud2 message;
    const auto status = sender_.encode(
        input, transform.pose, frames_.getNumSubscribers(), message.compressed_data);
    if (status.code() == SensorNodeCode::UsedLastTransform)
      ROS_WARN_THROTTLE(seconds_between_warnings,
                        "The transform of an earlier cloud is used, as TF has none: %s",
                        transform.failure.c_str());
    if (status.hasWarning())
      ROS_WARN_THROTTLE(seconds_between_warnings, "%s", status.message().c_str());
    if (status.code() == SensorNodeCode::NoTransform)
      ROS_WARN_THROTTLE(seconds_between_warnings,
                        "A cloud is dropped, as there is no transform: %s",
                        transform.failure.c_str());
    else if (!status.hasFrame())
      ROS_WARN_THROTTLE(
          seconds_between_warnings, "A cloud is dropped: %s", status.message().c_str());
    else
      send(header, message);
  }

  /** \brief Publishes a frame.
   * \param[in] header of the cloud
   * \param[in,out] message with the frame's bytes
   */
  void
  send(std_msgs::Header header, CompressedPointCloud2& message)
  {
    const pcl_ext::nodes::SensorNodeSettings settings = sender_.settings();
    if (settings.law != law_)
      ROS_INFO("The intensities are: %s", pcl_ext::nameOf(settings.law).c_str());
    law_ = settings.law;
    header.frame_id = global_frame_;
    message.header = header;
    pcl_ext::nodes::describeFrame(sender_.health().node, settings, message);
    frames_.publish(message);
  }

  /** \brief Counts clouds that were dropped before this one, by the network or by a full
   * queue. */
  void
  countMissed(std::uint32_t number)
  {
    // A larger gap is that of a sender that restarted, or of two senders.
    constexpr std::uint32_t largest_gap = 999;
    const std::uint32_t gap = number - last_number_.value_or(number) - 1;
    if (last_number_ && gap <= largest_gap)
      sender_.countMissed(gap);
    last_number_ = number;
  }

  void
  receiveRequest(const std_msgs::Empty&)
  {
    sender_.requestIFrame();
  }

  void
  reportHealth(const ros::WallTimerEvent&)
  {
    const SenderHealth health = sender_.health();
    diagnostic_msgs::DiagnosticArray message;
    message.header.stamp = ros::Time::now();
    message.status.push_back(
        toMessage(input_topic_,
                  pcl_ext::nodes::describeHealth(
                      health, reported_, pcl_ext::nodes::steadyTime())));
    diagnostics_.publish(message);
    reported_ = health;
  }

  ros::NodeHandle node_;
  const CompressorParameters parameters_ = readParameters();
  const std::string global_frame_ = pcl_ext::nodes::withoutLeadingSlash(
      valueOf<std::string>(parameters_.node, "global_frame"));
  const std::string input_topic_ = node_.resolveName("input");
  pcl_ext::nodes::CloudSender sender_;
  TransformLookup transforms_;
  std::optional<pcl_ext::IntensityLaw> law_; // of the last frame
  std::optional<std::uint32_t> last_number_; // sequence number of the last cloud
  SenderHealth reported_;

  ros::Publisher frames_;
  ros::Publisher diagnostics_;
  ros::Subscriber requests_;
  ros::Subscriber clouds_;
  ros::WallTimer report_timer_;
};

} // namespace pcl_ext_ros1

int
main(int argc, char** argv)
{
  return pcl_ext_ros1::runNode<pcl_ext_ros1::IntensityCompressor>(
      argc, argv, "intensity_compressor");
}
