// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/nodes/impl/health_report.h>
#include <pcl_ext/nodes/impl/node_parameters.h>
#include <pcl_ext/nodes/sensor_node.h>

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief The sending end of a stream of clouds, as nodes and plugins of ROS need it: a
 * SensorNode with parameters that change, requests for I-frames, and its health.
 * Independent of ROS; all members are thread-safe.
 */
class PCL_EXT_EXPORT CloudSender {
public:
  /** \brief A sender with the defaults of encodingParameters().
   * \param[in] settings for what is no parameter: clock and global_frame
   */
  explicit CloudSender(const SensorNodeSettings& settings = SensorNodeSettings());
  ~CloudSender();
  CloudSender(const CloudSender&) = delete;
  CloudSender&
  operator=(const CloudSender&) = delete;

  /** \brief Sets parameters, from the next cloud on, whose frame is then an I-frame of
   * a new stream. Setting what is set already changes nothing, and the stream goes on if
   * max_rate alone changes from one limit to another.
   * \param[in] values of encodingParameters(), each as convertedValue() returns it;
   * parameters that are missing keep their values
   * \return what is wrong, in one line, and nothing changes; empty if nothing
   */
  std::string
  setParameters(const ParameterValues& values);

  /** \brief A receiver requests an I-frame. Requests never cause two I-frames in a
   * row. */
  void
  requestIFrame();

  /** \brief Encodes the next cloud. Does not throw.
   *
   * Without a transform the last one is used, if that was of a cloud with the same
   * frame_id. Where the word auto for `intensity` means another law than for the last
   * cloud, a new stream begins.
   * \param[in] cloud as for SensorNode::encode
   * \param[in] sensor_to_world as for SensorNode::encode; the identity for frames in
   * the coordinate frame of the clouds: the sensor is at its origin, so that laws that
   * depend on the depth need no transform
   * \param[in] receivers how many there are; if more than for the last cloud, the frame
   * is an I-frame for those that are new
   * \param[out] bytes the frame; empty unless hasFrame() of the status
   * \return as SensorNode::encode
   */
  SensorNodeStatus
  encode(const pcl::PCLPointCloud2& cloud,
         const std::optional<WorldPose>& sensor_to_world,
         std::size_t receivers,
         std::vector<std::uint8_t>& bytes);

  /** \brief Counts clouds that were lost before they arrived. */
  void
  countMissed(std::size_t clouds);

  /** \brief Counts the clouds that were lost before one that arrived, by the gap
   * between its stamp and that of the previous one. For nodes whose clouds have no
   * numbers; to be called for each cloud, in the order of their arrival.
   * \param[in] stamp of the cloud; 0: it has none
   */
  void
  countMissedBefore(Time stamp);

  /** \brief Counts a transform that is used though it is not that of the cloud's
   * stamp. */
  void
  countLatestTransform();

  /** \brief The settings of the stream; before the first cloud `law` is that of clouds
   * without intensities. */
  SensorNodeSettings
  settings() const;

  /** \brief Of the current stream: counts begin again where parameters change. The time
   * of an arrival is that of a steady clock. */
  SenderHealth
  health() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
