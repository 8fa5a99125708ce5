// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/impl/node_parameters.h>

#include "pcl_ext_ros_common/node_interfaces.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace pcl_ext_ros_common {

/** \brief Parameters of a node that are described by a table: declared with
 * descriptors, checked when they are set, before and while the node runs.
 *
 * A value that is not allowed at the start is reported as an error, and the default
 * holds. One that is set later is refused with the reason, and nothing changes. Values
 * that contradict each other at the start are not checked here.
 */
class NodeParameters {
public:
  using Descriptions = std::vector<pcl_ext::nodes::ParameterDescription>;

  /** \brief How parameters are declared. */
  enum class Kind {
    Changeable, ///< may be set at any time
    ReadOnly,   ///< set at the start only
    Optional ///< may be set at any time; has no value, not even a default, until it is
  };

  /** \brief What is wrong with values that are allowed one by one, in one line that
   * begins with the name of a parameter; empty if nothing. Called for values that are
   * set later. */
  using Check = std::function<std::string(const pcl_ext::nodes::ParameterValues&)>;

  /** \brief Called with all values after some have changed. */
  using Listener = std::function<void(const pcl_ext::nodes::ParameterValues&)>;

  /** \brief Declares the parameters. The listener is not called for their first values.
   * \param[in] node whose parameters they are
   * \param[in] prefix before their names, such as "points.pcl_ext."; may be empty
   * \param[in] descriptions the table
   * \param[in] check may be empty
   * \param[in] listener may be empty
   * \param[in] kind of all of them
   */
  NodeParameters(const NodeInterfaces& node,
                 std::string prefix,
                 const Descriptions& descriptions,
                 Check check,
                 Listener listener,
                 Kind kind = Kind::Changeable);

  /** \brief The values by their names without prefix, each as convertedValue() returns
   * it; without those of optional parameters that are not set. */
  pcl_ext::nodes::ParameterValues
  values() const;

private:
  struct State;

  std::shared_ptr<State> state_;
  rclcpp::node_interfaces::OnSetParametersCallbackHandle::SharedPtr on_set_;
  rclcpp::node_interfaces::PostSetParametersCallbackHandle::SharedPtr post_set_;
};

} // namespace pcl_ext_ros_common
