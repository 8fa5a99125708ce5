#pragma once

#include <pcl_ext/nodes/node_parameters.h>
#include <pcl_ext/view/view_server.h>

#include <ros/time.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace pcl_ext_ros1 {

/** \brief Shows compressed streams in browsers. Thread-safe. */
class StreamView {
public:
  /** \brief Begins to serve.
   * \param[in] parameters of centralNodeParameters()
   * \param[in] topics of the streams
   * \param[in] request_i_frame asks the sender of a stream, by its index in the topics; called
   * by a thread of this
   * \param[in] metrics text about the streams for Prometheus; called likewise
   * \throws WrongParameter if there is no page, the port is taken or the address is wrong
   */
  StreamView(const pcl_ext::nodes::ParameterValues& parameters,
             const std::vector<std::string>& topics,
             const std::function<void(std::size_t)>& request_i_frame,
             const std::function<std::string()>& metrics);

  /** \brief Shows the next frame of a stream; bytes that are no frame are left out. */
  void
  show(std::size_t stream,
       const ros::Time& stamp,
       const std::vector<std::uint8_t>& frame);

private:
  pcl_ext::view::ViewServer server_;
};

} // namespace pcl_ext_ros1
