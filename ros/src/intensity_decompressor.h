#pragma once

#include <pcl_ext/nodes/central_node.h>

#include "decompressor_parameters.h"
#include "fused_map.h"
#include "health_report.h"
#include "stream_noise.h"
#include "transform_lookup.h"

#include <pcl_ext_ros/CompressedPointCloud2.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace pcl_ext_ros {

/** \brief The central node: compressed frames of many streams in, denoised voxels out, of
 * each stream and of all together, and a map of them. README.md tells its topics, services
 * and parameters. */
class IntensityDecompressor {
public:
  /** \brief Reads the parameters and connects.
   * \throws WrongParameter
   */
  IntensityDecompressor();

  /** \brief Works until ROS shuts down, then writes the map, if there is one. */
  int
  run();

private:
  /** \brief Whether the map takes rays where it knows the sensor. */
  enum class Rays { Yes, No };

  /** \brief One stream; its address stays. */
  struct Stream {
    Stream(std::string resolved_topic,
           const StreamParameters& stream_parameters,
           const NoiseParameters& noise_of_all);

    std::string topic; ///< resolved; the stream's name for the central node
    StreamParameters parameters;
    StreamNoise noise;

    ros::Publisher voxels;
    ros::Publisher i_frame_requests;
    ros::Subscriber frames;

    // Written where frames arrive and are decoded, read by timers.
    std::atomic<std::int64_t> last_arrival{0}; ///< ns of the wall clock; 0: never
    std::atomic<std::uint64_t> left_out{0};    ///< messages of another frame or format

    std::size_t mapped = 0; ///< number of the last frame that the map took
    std::uint64_t reported_left_out = 0;
    pcl_ext::nodes::StreamHealth reported; ///< as of the last report
  };

  void
  addStream(const StreamParameters& parameters);
  void
  subscribe(Stream& stream);
  void
  createTimers();

  /** \brief Hands a frame to the central node, if it is in the global frame. */
  void
  receive(Stream& stream, const CompressedPointCloud2& message);

  /** \brief The central node's listener: publishes what a frame became. */
  void
  showFrame(const pcl_ext::nodes::ReceivedFrame& frame);

  void
  updateNoise(const ros::WallTimerEvent&);
  void
  publishMerged(const ros::WallTimerEvent&);

  /** \brief Puts what is new since the last call into the map. */
  void
  updateMap(Rays rays);
  bool
  writeMap(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response);
  void
  reportHealth(const ros::WallTimerEvent&);
  static HealthReport
  describeHealth(const Stream& stream, const pcl_ext::nodes::StreamHealth& now);

  ros::NodeHandle node_;
  ros::NodeHandle private_node_{"~"};
  DecompressorParameters parameters_;
  std::vector<std::unique_ptr<Stream>> streams_;
  std::unordered_map<std::string, Stream*> streams_by_topic_;
  std::optional<TransformLookup> transforms_; // where a stream has a sensor_frame
  std::optional<FusedMap> map_;               // touched by map_queue_ alone

  ros::CallbackQueue map_queue_; // a map with rays takes longer than frames may wait
  ros::Publisher merged_;
  ros::Publisher diagnostics_;
  ros::ServiceServer map_service_;
  std::atomic<std::uint64_t> map_nodes_{0};
  ros::WallTimer noise_timer_;
  ros::WallTimer merge_timer_;
  ros::WallTimer map_timer_;
  ros::WallTimer report_timer_;
  pcl_ext::io::VoxelFrame merged_voxels_; // members to keep their memory
  pcl_ext::io::VoxelFrame map_voxels_;

  // Last, as it calls showFrame until it is gone.
  std::optional<pcl_ext::nodes::CentralNode> central_node_;
};

} // namespace pcl_ext_ros
