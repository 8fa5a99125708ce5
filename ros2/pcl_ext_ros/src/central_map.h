// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/impl/merged_map.h>

#include "map_publisher.h"
#include "stream.h"
#include "transform_lookup.h"

#include <pcl_ext_ros_common/throttled_log.hpp>
#include <std_srvs/srv/trigger.hpp>

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext_ros {

/** \brief The map of the central node: its timer, its service, its topic and its file.
 *
 * The map has a callback group of its own, as one with rays can take longer than frames
 * can wait. It begins with the first subscriber, unless it is written to a file.
 */
class CentralMap : public std::enable_shared_from_this<CentralMap> {
public:
  /** \brief The streams of the central node at present. */
  using Streams = std::function<std::vector<std::shared_ptr<Stream>>()>;

  /** \param[in] node whose parameters are `values`
   * \param[in] values of centralNodeParameters()
   * \param[in] streams called by any thread while this exists
   * \param[in] central_node that decodes them
   */
  CentralMap(rclcpp::Node& node,
             const pcl_ext::nodes::ParameterValues& values,
             Streams streams,
             std::shared_ptr<const pcl_ext::nodes::CentralNode> central_node);

  /** \brief Creates the timer and the service. */
  void
  connect(rclcpp::Node& node);

  /** \brief Listens to transforms, if it takes rays from a stream. Called before that is
   * one of the streams. */
  void
  prepareFor(rclcpp::Node& node, const Stream& stream);

  /** \brief Inserts the last frames, without rays, as these would take longer than a
   * node has to stop, and writes the map unless it is empty or has no file. */
  void
  finish() noexcept;

  /** \brief Why there is no map in spite of `map_path`; empty: there is. */
  const std::string&
  fault() const
  {
    return fault_;
  }

  std::size_t
  nodes() const
  {
    return nodes_;
  }

private:
  enum class Rays { Yes, No };

  void
  updateOnTimer();

  /** \brief Inserts the frames since the last call into the map. The mutex is
   * locked. */
  void
  update(Rays rays);

  void
  write(std_srvs::srv::Trigger::Response& response);

  std::optional<octomap::point3d>
  findSensor(const std::string& sensor_frame, pcl_ext::nodes::Time stamp);

  rclcpp::Logger logger_;
  pcl_ext_ros_common::ThrottledLog warnings_{logger_};
  rclcpp::Clock::SharedPtr clock_;
  const std::string global_frame_;
  const std::string path_; ///< empty: no file
  std::string fault_;
  const double seconds_between_updates_;
  const double full_intensity_;
  std::mutex
      mutex_; // guards map_ and transforms_: callbacks may run while the node ends
  pcl_ext::nodes::detail::MergedMap map_;
  std::string told_fault_; ///< see MergedMap::faultOfFrames()
  const Streams streams_;
  const std::shared_ptr<const pcl_ext::nodes::CentralNode> central_node_;
  MapPublisher publisher_;
  std::optional<TransformLookup> transforms_; // where a stream had a sensor_frame
  std::atomic<std::size_t> nodes_{0};

  rclcpp::CallbackGroup::SharedPtr group_;
  rclcpp::TimerBase::SharedPtr timer_;
  rclcpp::Service<std_srvs::srv::Trigger>::SharedPtr service_;
};

} // namespace pcl_ext_ros
