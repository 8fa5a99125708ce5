#pragma once

#include <pcl_ext/nodes/impl/merged_map.h>

#include "node_parameters.h"
#include "transform_lookup.h"

#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext_ros1 {

/** \brief The map of the central node: its timer, its service and its file. It has a thread
 * of its own, as a map with rays can take longer than frames can wait. */
class CentralMap {
public:
  /** \param[in] private_node whose service writes the map
   * \param[in] parameters of the node; without map_path there is no map
   * \param[in] central_node that decodes the streams; must exist until finish()
   */
  CentralMap(const ros::NodeHandle& private_node,
             const DecompressorParameters& parameters,
             const pcl_ext::nodes::CentralNode& central_node);

  /** \brief Adds a stream; before start().
   * \param[in] topic its name in the central node
   * \param[in] sensor_frame TF frame of its sensor; empty: no rays are taken
   */
  void
  addStream(const std::string& topic, const std::string& sensor_frame)
  {
    streams_.emplace_back(topic, sensor_frame);
  }

  /** \brief Begins to update the map and to answer the service. */
  void
  start()
  {
    spinner_.start();
  }

  /** \brief Inserts the last frames without rays, which would take longer than roslaunch gives
   * a node to stop, and writes the map unless it is empty.
   * \return exit status of the node
   */
  int
  finish();

  /** \brief Whether there is a map. */
  bool
  exists() const
  {
    return map_.has_value();
  }

  std::size_t
  nodes() const
  {
    return nodes_;
  }

private:
  /** \brief Whether the map takes rays from the sensors whose frame is known. */
  enum class Rays { Yes, No };

  /** \brief Inserts the frames since the last call into the map. */
  void
  update(Rays rays);

  std::optional<octomap::point3d>
  findSensor(const std::string& sensor_frame, pcl_ext::nodes::Time stamp) const;

  bool
  write(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  const std::string path_; // empty: no map
  const pcl_ext::nodes::CentralNode& central_node_;
  std::vector<std::pair<std::string, std::string>> streams_; // topic and sensor frame
  // Used by callbacks of queue_ only, except for finish().
  std::optional<pcl_ext::nodes::detail::MergedMap> map_;
  std::optional<TransformLookup> transforms_; // where a stream has a sensor frame
  std::atomic<std::size_t> nodes_{0};

  ros::CallbackQueue queue_;
  ros::NodeHandle node_; // with this queue
  ros::ServiceServer service_;
  ros::WallTimer timer_;
  ros::AsyncSpinner spinner_;
};

} // namespace pcl_ext_ros1
