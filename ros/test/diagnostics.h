/** \file
 * \brief The reports of a node on /diagnostics.
 */
#pragma once

#include "recorder.h"

#include <gtest/gtest.h>

#include <diagnostic_msgs/DiagnosticArray.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace pcl_ext_ros1 {
namespace test {

using diagnostic_msgs::DiagnosticStatus;

/** \brief Records one entry of one node. */
class Diagnostics {
public:
  /** \brief Starts to record.
   * \param[in] node_name full name
   * \param[in] entry part of the entry's name; empty: the node's first entry
   */
  explicit Diagnostics(const std::string& node_name, std::string entry = "")
  : node_name_(node_name.substr(1)), entry_(std::move(entry))
  {}

  /** \brief The last value of a key; nothing if it is missing or no number. */
  std::optional<double>
  value(const std::string& key) const
  {
    const std::vector<DiagnosticStatus> all = entries();
    if (all.empty())
      return std::nullopt;
    for (const auto& pair : all.back().values) {
      char* end = nullptr;
      const double number = std::strtod(pair.value.c_str(), &end);
      if (pair.key == key && end != pair.value.c_str() && *end == '\0')
        return number;
    }
    return std::nullopt;
  }

  /** \brief Waits until a key has a value; a failure of the test if it does not. */
  void
  expectValue(const std::string& key, double expected) const
  {
    EXPECT_TRUE(waitFor([&] { return value(key) == expected; }))
        << key << " is not " << expected << '\n'
        << text();
  }

  /** \brief Waits for an entry of a level; a failure of the test if there is none. */
  void
  expectLevel(std::uint8_t level) const
  {
    EXPECT_TRUE(waitFor([&] {
      const std::vector<DiagnosticStatus> all = entries();
      return std::any_of(all.begin(), all.end(), [&](const DiagnosticStatus& entry) {
        return entry.level == level;
      });
    })) << "no level "
        << int{level} << '\n'
        << text();
  }

  /** \brief All entries, the oldest first. */
  std::vector<DiagnosticStatus>
  entries() const
  {
    std::vector<DiagnosticStatus> found;
    for (const auto& report : reports_.messages())
      for (const DiagnosticStatus& entry : report->status)
        if (entry.name.rfind(node_name_ + ":", 0) == 0 &&
            entry.name.find(entry_) != std::string::npos) {
          found.push_back(entry);
          break;
        }
    return found;
  }

  /** \brief The last entry as text. */
  std::string
  text() const
  {
    const std::vector<DiagnosticStatus> all = entries();
    std::ostringstream text;
    if (!all.empty())
      text << all.back();
    return text.str();
  }

private:
  const std::string node_name_; // without the leading slash, as in the entries' names
  const std::string entry_;
  Recorder<diagnostic_msgs::DiagnosticArray> reports_{"/diagnostics"};
};

} // namespace test
} // namespace pcl_ext_ros1
