#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/nodes/health_report.h>
#include <pcl_ext/nodes/node_parameters.h>
#include <pcl_ext/nodes/sensor_node.h>

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace pcl_ext {
namespace nodes {

/** \brief The sending end of a transport of clouds, as a plugin of ROS 2's
 * point_cloud_transport needs it: any cloud in, one frame out, in the cloud's own coordinate
 * frame. Independent of ROS; all members are thread-safe.
 *
 * The sensor is at the origin of its clouds (x right, y down, z along the optical axis), so
 * that laws that depend on the depth need no transform. Use SensorNode for clouds of a sensor
 * in a common coordinate frame.
 */
class PCL_EXT_EXPORT CloudSender {
public:
  /** \brief A sender with the defaults of encodingParameters(). */
  CloudSender();
  ~CloudSender();
  CloudSender(const CloudSender&) = delete;
  CloudSender&
  operator=(const CloudSender&) = delete;

  /** \brief Sets parameters, from the next cloud on, whose frame is then an I-frame of a new
   * stream. Setting what is set already changes nothing.
   * \param[in] values of encodingParameters(), each as convertedValue() returns it;
   * parameters that are missing keep their values
   * \return what is wrong, in one line, and nothing changes; empty if nothing
   */
  std::string
  setParameters(const ParameterValues& values);

  /** \brief A receiver requests an I-frame. Requests never cause two I-frames in a row. */
  void
  requestIFrame();

  /** \brief Encodes the next cloud. Does not throw.
   * \param[in] cloud any layout with x, y, z; metres; stamp in microseconds
   * \param[in] receivers how many there are; if more than for the last cloud, the frame is
   * an I-frame for those that are new
   * \param[out] bytes the frame; empty unless hasFrame() of the status
   * \return as SensorNode::encode
   */
  SensorNodeStatus
  encode(const pcl::PCLPointCloud2& cloud,
         std::size_t receivers,
         std::vector<std::uint8_t>& bytes);

  /** \brief Format of the frames, as the parameters say. */
  io::StreamFormat
  format() const;

  /** \brief Of the current stream: counts begin again where parameters change. The time of
   * an arrival is that of a steady clock. */
  SenderHealth
  health() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace nodes
} // namespace pcl_ext
