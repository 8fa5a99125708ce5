#pragma once

#include <ros/node_handle.h>
#include <XmlRpcValue.h>

#include <limits>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext_ros {

/** \brief Numbers that a float holds are from minus this to this. */
constexpr double largest_float = std::numeric_limits<float>::max();

/** \brief A parameter that the node cannot work with; says its name, its value and what
 * is allowed, in one line. */
class WrongParameter : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/** \brief A value for a message, in one line. */
std::string
toText(const XmlRpc::XmlRpcValue& value);

/** \brief The number that a value is, whole or not; none if it is something else. */
std::optional<double>
toNumber(XmlRpc::XmlRpcValue value);

/** \brief The number that a value is, if it is finite as a float; none if it is not. */
std::optional<float>
toFloat(const XmlRpc::XmlRpcValue& value);

/** \brief What a value that is true or false is; none if it is something else. */
std::optional<bool>
toFlag(XmlRpc::XmlRpcValue value);

/** \brief Reads the private parameters of this node and checks type and range.
 *
 * All members throw WrongParameter. A parameter that is not set has its default, which is
 * taken as it is.
 */
class ParameterReader {
public:
  /** \brief A finite number within [lowest, highest]. */
  double
  number(const std::string& name, double default_value, double lowest, double highest);

  /** \brief A number that is finite as a float. */
  float
  finite(const std::string& name, float default_value);

  /** \brief A whole number within [lowest, highest]. */
  int
  count(const std::string& name, int default_value, int lowest, int highest);

  /** \brief true or false. */
  bool
  flag(const std::string& name, bool default_value);

  std::string
  text(const std::string& name, const std::string& default_value);

  /** \brief A text that is not empty. */
  std::string
  nonEmptyText(const std::string& name, const std::string& default_value);

  /** \brief What a word stands for.
   * \param[in] name of the parameter
   * \param[in] default_word one of the words
   * \param[in] values of all words
   */
  template <typename ValueT>
  ValueT
  choice(const std::string& name,
         const std::string& default_word,
         const std::map<std::string, ValueT>& values)
  {
    const std::string word = text(name, default_word);
    const auto entry = values.find(word);
    if (entry != values.end())
      return entry->second;
    std::string known;
    for (const auto& value : values)
      known += (known.empty() ? "" : ", ") + value.first;
    refuse(name, "'" + word + "'", "one of: " + known);
  }

  /** \brief The elements of a list; none if the parameter is not set. */
  std::optional<std::vector<XmlRpc::XmlRpcValue>>
  list(const std::string& name);

  /** \brief True if the parameter is set. */
  bool
  isSet(const std::string& name);

  /** \brief Throws.
   * \param[in] name of the parameter, as it is to be shown
   * \param[in] value as it is to be shown
   * \param[in] allowed what it must be
   */
  [[noreturn]] static void
  refuse(const std::string& name, const std::string& value, const std::string& allowed);

  /** \brief Lets a name of the private namespace pass that no other member asked for. */
  void
  know(const std::string& name);

  /** \brief Refuses every parameter that is set and that nobody asked for: a name with a
   * slip would else be a default that nobody sees. */
  void
  refuseUnknownNames() const;

private:
  /** \brief The value of a parameter, if it is set; its name is known from now on. */
  std::optional<XmlRpc::XmlRpcValue>
  find(const std::string& name);

  ros::NodeHandle private_node_{"~"};
  std::set<std::string> known_names_;
};

} // namespace pcl_ext_ros
