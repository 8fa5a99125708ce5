// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/impl/node_parameters.h>
#include <pcl_ext/nodes/stream_health.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace pcl_ext_ros {

/** \brief Shows compressed streams in browsers. Thread-safe. */
class StreamView {
public:
  /** \brief Begins to serve.
   * \param[in] parameters of centralNodeParameters()
   * \param[in] request_i_frame asks the sender of a stream, by its topic; called by a
   * thread of this
   * \param[in] metrics text about the streams for Prometheus; called likewise
   * \throws std::runtime_error if there is no page, the port is taken or the address is
   * wrong
   */
  StreamView(const pcl_ext::nodes::ParameterValues& parameters,
             const std::function<void(const std::string&)>& request_i_frame,
             const std::function<std::string()>& metrics);
  ~StreamView();

  /** \brief Shows the next frame of a stream, by its topic; bytes that are no frame are
   * left out. */
  void
  show(const std::string& topic,
       pcl_ext::nodes::Time stamp,
       const std::vector<std::uint8_t>& frame);

  /** \brief Where to look at the streams. */
  std::string
  url() const;

  /** \brief False if others than this machine reach it. */
  bool
  isLoopback() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace pcl_ext_ros
