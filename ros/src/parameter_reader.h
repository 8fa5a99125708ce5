// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/impl/node_parameters.h>

#include <ros/node_handle.h>
#include <XmlRpcValue.h>

#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext_ros1 {

/** \brief A parameter that the node cannot use. The message has the name, the value and
 * the allowed values in one line. */
class WrongParameter : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/** \brief Reads private parameters of this node and checks type and range. doc/nodes.md
 * has their units, defaults and ranges.
 *
 * All members throw WrongParameter.
 */
class ParameterReader {
public:
  /** \brief The values of a table's parameters, the defaults of those that are not set.
   */
  pcl_ext::nodes::ParameterValues
  values(const std::vector<pcl_ext::nodes::ParameterDescription>& parameters);

  /** \brief The topics of a list, which must not be empty; nothing if the parameter is
   * not set. */
  std::optional<std::vector<std::string>>
  topics(const std::string& name);

  /** \brief Refuses every parameter that is set and was not read. Without this check a
   * mistyped name would silently leave the default in force. */
  void
  refuseUnknownNames() const;

private:
  /** \brief The value of a parameter; nothing if it is not set. */
  std::optional<XmlRpc::XmlRpcValue>
  find(const std::string& name);

  ros::NodeHandle private_node_{"~"};
  std::set<std::string> known_names_;
};

} // namespace pcl_ext_ros1
