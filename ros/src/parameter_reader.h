#pragma once

#include <pcl_ext/nodes/node_parameters.h>

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

/** \brief A value in one line, for messages. */
std::string
toText(const XmlRpc::XmlRpcValue& value);

/** \brief Nothing if the value is of a type that no parameter of a table has, as maps, and
 * lists of other elements than numbers. */
std::optional<pcl_ext::nodes::ParameterValue>
toParameterValue(XmlRpc::XmlRpcValue value);

/** \brief The value of a parameter of a table; nothing if it is not allowed. */
std::optional<pcl_ext::nodes::ParameterValue>
convertedValue(const pcl_ext::nodes::ParameterDescription& parameter,
               const XmlRpc::XmlRpcValue& value);

/** \brief Reads private parameters of this node and checks type and range.
 *
 * All members throw WrongParameter.
 */
class ParameterReader {
public:
  /** \brief The values of a table's parameters, the defaults of those that are not set. */
  pcl_ext::nodes::ParameterValues
  values(const std::vector<pcl_ext::nodes::ParameterDescription>& parameters);

  /** \brief A value that a description of a table allows; nothing if it is not set.
   * \param[in] name that of the description, or another one
   */
  std::optional<pcl_ext::nodes::ParameterValue>
  value(const std::string& name,
        const pcl_ext::nodes::ParameterDescription& description);

  /** \brief The elements of a list; nothing if the parameter is not set. */
  std::optional<std::vector<XmlRpc::XmlRpcValue>>
  list(const std::string& name);

  /** \brief Throws.
   * \param[in] name of the parameter
   * \param[in] value as it is printed
   * \param[in] allowed values, as they are printed
   */
  [[noreturn]] static void
  refuse(const std::string& name, const std::string& value, const std::string& allowed);

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
