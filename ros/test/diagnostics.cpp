#include "diagnostics.h"

#include <algorithm>
#include <cstdlib>
#include <sstream>

namespace pcl_ext_ros {
namespace test {

using diagnostic_msgs::DiagnosticStatus;

Diagnostics::Diagnostics(const std::string& node_name, std::string entry)
: node_name_(node_name.substr(1)), entry_(std::move(entry))
{}

std::optional<double>
Diagnostics::value(const std::string& key) const
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

bool
Diagnostics::waitForValue(const std::string& key, double wanted, bool or_more) const
{
  return waitFor([&] {
    const std::optional<double> now = value(key);
    return now && (*now == wanted || (or_more && *now > wanted));
  });
}

bool
Diagnostics::waitForLevel(std::uint8_t level) const
{
  return waitFor([&] { return sawLevel(level); });
}

bool
Diagnostics::sawLevel(std::uint8_t level) const
{
  const std::vector<DiagnosticStatus> all = entries();
  return std::any_of(all.begin(), all.end(), [&](const DiagnosticStatus& entry) {
    return entry.level == level;
  });
}

std::vector<DiagnosticStatus>
Diagnostics::entries() const
{
  std::vector<DiagnosticStatus> found;
  for (const auto& report : reports_.messages())
    for (const DiagnosticStatus& entry : report->status)
      if (entry.name.compare(0, node_name_.size() + 1, node_name_ + ":") == 0 &&
          entry.name.find(entry_) != std::string::npos) {
        found.push_back(entry);
        break;
      }
  return found;
}

std::string
Diagnostics::text() const
{
  const std::vector<DiagnosticStatus> all = entries();
  std::ostringstream text;
  if (!all.empty())
    text << all.back();
  return text.str();
}

} // namespace test
} // namespace pcl_ext_ros
