/** \file
 * \brief What a node tells about its health.
 */
#pragma once

#include "recorder.h"

#include <diagnostic_msgs/DiagnosticArray.h>

#include <cstdint>
#include <optional>
#include <string>

namespace pcl_ext_ros {
namespace test {

/** \brief Follows one entry of one node on /diagnostics. */
class Diagnostics {
public:
  /** \brief Listens from now on.
   * \param[in] node_name full name
   * \param[in] entry part of the entry's name; empty: the node's first one
   */
  explicit Diagnostics(const std::string& node_name, std::string entry = "");

  /** \brief The last value of a key as a number; none if it was not told, or is none. */
  std::optional<double>
  value(const std::string& key) const;

  /** \brief Waits until a key has a value.
   * \param[in] key of the entry
   * \param[in] wanted the value
   * \param[in] or_more a higher value will do, too
   */
  bool
  waitForValue(const std::string& key, double wanted, bool or_more = false) const;

  /** \brief Waits until an entry is as bad as this. */
  bool
  waitForLevel(std::uint8_t level) const;

  /** \brief True if one entry was. */
  bool
  sawLevel(std::uint8_t level) const;

  /** \brief All entries until now, the oldest first. */
  std::vector<diagnostic_msgs::DiagnosticStatus>
  entries() const;

  /** \brief The last entry, to be read by people. */
  std::string
  text() const;

private:
  std::string node_name_; // without the slash, as in the entries' names
  std::string entry_;
  Recorder<diagnostic_msgs::DiagnosticArray> reports_{"/diagnostics"};
};

} // namespace test
} // namespace pcl_ext_ros
