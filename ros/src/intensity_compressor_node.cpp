/** \file
 * \brief The node of a sensor: clouds in, compressed frames out.
 */
#include <pcl_ext/nodes/sensor_node.h>

#include "health_report.h"
#include "message_conversions.h"
#include "node_main.h"
#include "node_parameters.h"
#include "parameter_reader.h"
#include "transform_lookup.h"

#include <pcl/common/io.h>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <pcl_conversions/pcl_conversions.h>
#include <pcl_ext_ros/CompressedPointCloud2.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Empty.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext_ros {

using diagnostic_msgs::DiagnosticStatus;
using pcl_ext::nodes::SensorNodeCode;
using pcl_ext::nodes::SensorNodeStatistics;

/** \brief Compresses the clouds of one sensor. README.md has the topics and parameters.
 * All callbacks run in the thread of run(). */
class IntensityCompressor {
public:
  /** \brief Reads the parameters and connects.
   * \throws WrongParameter
   */
  IntensityCompressor()
  : sensor_node_(settings_)
  , transforms_(parameters_.global_frame, parameters_.tf_timeout)
  {
    const std::string output_topic = node_.resolveName(input_topic_ + "/pcl_ext");
    // A new subscriber can decode from the next I-frame on.
    const auto on_subscriber = [this](const ros::SingleSubscriberPublisher&) {
      i_frame_is_due_ = true;
    };
    frames_ = node_.advertise<CompressedPointCloud2>(output_topic, 40, on_subscriber);
    diagnostics_ =
        node_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 10);
    requests_ = node_.subscribe(output_topic + "/request_i_frame",
                                10,
                                &IntensityCompressor::receiveRequest,
                                this);
    clouds_ = node_.subscribe(input_topic_,
                              parameters_.queue_size,
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
  /** \brief Counts of this node, besides those of SensorNode. */
  struct Counts {
    std::size_t clouds = 0;                ///< received
    std::size_t clouds_missed = 0;         ///< gaps in the sequence numbers
    std::size_t latest_transforms = 0;     ///< used, as there was none at the stamp
    std::size_t clouds_of_other_frame = 0; ///< dropped: another frame, unknown to TF
    std::size_t i_frame_requests = 0;      ///< received
  };

  void
  compress(const sensor_msgs::PointCloud2::Ptr& cloud)
  {
    countMissed(cloud->header.seq);
    ++counts_.clouds;
    last_arrival_ = ros::WallTime::now();
    std_msgs::Header header = cloud->header;
    const FoundTransform transform = transforms_.toGlobalFrame(header);
    if (transform.is_latest) {
      ++counts_.latest_transforms;
      ROS_WARN_THROTTLE(
          seconds_between_warnings,
          "The latest transform is used, as there is none at the stamp: %s",
          transform.failure.c_str());
    }
    // The sensor node would use its last transform, which is that of another frame.
    if (!transform.pose && header.frame_id != frame_of_last_transform_) {
      ++counts_.clouds_of_other_frame;
      ROS_WARN_THROTTLE(seconds_between_warnings,
                        "A cloud is dropped, as there is no transform: %s",
                        transform.failure.c_str());
      return;
    }

    pcl::PCLPointCloud2 input;
    pcl_conversions::moveToPCL(*cloud, input);
    if (!has_frame_)
      chooseIntensities(input);
    passOnIFrameRequest();
    std::vector<std::uint8_t> bytes;
    const auto status = sensor_node_.encode(input, transform.pose, bytes);
    if (transform.pose && status.code() != SensorNodeCode::InvalidTransform)
      frame_of_last_transform_ = header.frame_id;
    if (status.code() == SensorNodeCode::UsedLastTransform)
      ROS_WARN_THROTTLE(seconds_between_warnings,
                        "The transform of an earlier cloud is used, as TF has none: %s",
                        transform.failure.c_str());
    if (status.hasWarning())
      ROS_WARN_THROTTLE(seconds_between_warnings, "%s", status.message().c_str());
    if (!status.hasFrame()) {
      ROS_WARN_THROTTLE(
          seconds_between_warnings, "A cloud is dropped: %s", status.message().c_str());
      return;
    }
    if (!has_frame_)
      ROS_INFO("The intensities are: %s", pcl_ext::nameOf(settings_.law).c_str());
    has_frame_ = true;
    ++frames_since_request_;
    header.frame_id = parameters_.global_frame;
    const SensorNodeStatistics statistics = sensor_node_.statistics();
    frames_.publish(toMessage(header,
                              settings_.compression.format,
                              statistics.frame.coding.voxels,
                              statistics.preprocessing.has_colours,
                              std::move(bytes)));
  }

  /** \brief The first cloud that becomes a frame decides what the intensities are, if no
   * parameter does: all clouds of a stream have intensities of the same kind. */
  void
  chooseIntensities(const pcl::PCLPointCloud2& cloud)
  {
    const auto law_before = settings_.law;
    settings_ = sensorNodeSettings(
        parameters_, pcl::getFieldIndex(cloud, settings_.intensity_field) != -1);
    if (settings_.law != law_before)
      sensor_node_ = pcl_ext::nodes::SensorNode(settings_);
  }

  /** \brief Counts clouds that were dropped before this one, by the network or by a full
   * queue. */
  void
  countMissed(std::uint32_t number)
  {
    // A larger gap is that of a sender that restarted, or of two senders.
    constexpr std::uint32_t largest_gap = 999;
    const std::uint32_t gap = number - last_number_ - 1;
    if (counts_.clouds != 0 && gap <= largest_gap)
      counts_.clouds_missed += gap;
    last_number_ = number;
  }

  /** \brief Requests an I-frame, unless the last frame was one on request: a request that
   * arrives now may be older than that frame. */
  void
  passOnIFrameRequest()
  {
    if (!i_frame_is_due_ || frames_since_request_ < 2)
      return;
    sensor_node_.requestIFrame();
    i_frame_is_due_ = false;
    frames_since_request_ = 0;
  }

  void
  receiveRequest(const std_msgs::Empty&)
  {
    ++counts_.i_frame_requests;
    i_frame_is_due_ = true;
  }

  void
  reportHealth(const ros::WallTimerEvent&)
  {
    const SensorNodeStatistics now = sensor_node_.statistics();
    diagnostic_msgs::DiagnosticArray message;
    message.header.stamp = ros::Time::now();
    message.status.push_back(describeHealth(now).status());
    diagnostics_.publish(message);
    if (parameters_.statistics)
      ROS_INFO("%.1f frames/s, %.1f kB/s, ratio %.1f, %.1f ms, %zu voxels, %.3f bytes "
               "per voxel",
               now.rates.frames_per_second,
               1e-3 * now.rates.bytes_per_second,
               now.compressionRatio(),
               1e3 * now.rates.mean_cycle_seconds,
               now.frame.coding.voxels,
               now.frame.bytesPerVoxel());
    reported_counts_ = counts_;
    reported_statistics_ = now;
  }

  HealthReport
  describeHealth(const SensorNodeStatistics& now) const
  {
    HealthReport report(input_topic_);
    const std::size_t without_transform =
        now.clouds_without_transform + counts_.clouds_of_other_frame;
    const std::size_t last_transforms =
        now.frames_with_last_transform + counts_.latest_transforms;
    const SensorNodeStatistics& before = reported_statistics_;
    report.checkArrival("clouds", last_arrival_);
    if (without_transform >
        before.clouds_without_transform + reported_counts_.clouds_of_other_frame)
      report.raise(DiagnosticStatus::ERROR, "Clouds without transform are dropped");
    if (counts_.clouds_missed > reported_counts_.clouds_missed)
      report.raise(DiagnosticStatus::WARN,
                   "Clouds are missing: lost on the way or dropped from the queue");
    if (now.clouds_refused > before.clouds_refused)
      report.raise(DiagnosticStatus::ERROR, "Clouds are refused");
    if (last_transforms >
        before.frames_with_last_transform + reported_counts_.latest_transforms)
      report.raise(DiagnosticStatus::WARN, "A transform of another time is used");

    report.addRates(now.rates);
    report.add("compression ratio", now.compressionRatio());
    report.add("clouds", counts_.clouds);
    report.add("clouds missed", counts_.clouds_missed);
    report.add("frames", now.frames);
    report.add("I-frames", now.i_frames);
    report.add("I-frame requests", counts_.i_frame_requests);
    report.add("frames with last transform", last_transforms);
    report.add("clouds without transform", without_transform);
    report.add("clouds refused", now.clouds_refused);
    report.add("points", now.preprocessing.points);
    report.add("points cropped", now.preprocessing.points_cropped);
    report.add("points not finite", now.preprocessing.points_not_finite);
    report.add("outliers removed", now.outliers_removed);
    report.add("voxels", now.frame.coding.voxels);
    report.add("bytes per voxel", now.frame.bytesPerVoxel());
    return report;
  }

  ros::NodeHandle node_;
  const CompressorParameters parameters_ = readCompressorParameters();
  const std::string input_topic_ = node_.resolveName("input");
  pcl_ext::nodes::SensorNodeSettings settings_ = sensorNodeSettings(parameters_, false);
  pcl_ext::nodes::SensorNode sensor_node_;
  bool has_frame_ = false; // has encoded a cloud
  TransformLookup transforms_;
  std::string frame_of_last_transform_;

  bool i_frame_is_due_ = false;
  std::size_t frames_since_request_ = 2; // since one was passed on

  ros::WallTime last_arrival_;
  std::uint32_t last_number_ = 0; // sequence number of the last cloud
  Counts counts_;
  Counts reported_counts_; // as of the last report
  SensorNodeStatistics reported_statistics_;

  ros::Publisher frames_;
  ros::Publisher diagnostics_;
  ros::Subscriber requests_;
  ros::Subscriber clouds_;
  ros::WallTimer report_timer_;
};

} // namespace pcl_ext_ros

int
main(int argc, char** argv)
{
  return pcl_ext_ros::runNode<pcl_ext_ros::IntensityCompressor>(
      argc, argv, "intensity_compressor");
}
