// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/file_stamps.h"

#include "clouds/bin_file.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace pcl_ext {
namespace clouds {

namespace {

constexpr const char* digits = "0123456789";
constexpr std::size_t digits_of_clock = 10; // of seconds, from 2001 to 2286
constexpr std::size_t digits_of_nanoseconds = 9;

std::int64_t
powerOfTen(std::size_t exponent)
{
  std::int64_t power = 1;
  while (exponent-- > 0)
    power *= 10;
  return power;
}

/** \brief Whole seconds and a fraction of them, or nothing if that is no time. */
std::optional<std::chrono::nanoseconds>
stampOfSeconds(const std::string& whole, const std::string& fraction)
{
  const bool is_clock = whole.size() == digits_of_clock && whole.front() != '0';
  const bool is_padded = fraction.size() == 6 || fraction.size() == 9;
  if (whole.empty() || whole.size() > digits_of_clock || fraction.empty() ||
      fraction.size() > digits_of_nanoseconds || (!is_clock && !is_padded))
    return std::nullopt;
  const std::int64_t nanoseconds =
      std::stoll(fraction) * powerOfTen(digits_of_nanoseconds - fraction.size());
  return std::chrono::seconds(std::stoll(whole)) +
         std::chrono::nanoseconds(nanoseconds);
}

std::optional<std::chrono::nanoseconds>
stampOfInteger(const std::string& number)
{
  const std::size_t more = number.size() - digits_of_clock; // digits than of seconds
  const bool is_known = number.size() >= digits_of_clock &&
                        more <= digits_of_nanoseconds && more % 3 == 0;
  constexpr char largest[] = "9223372036854775807";
  const bool is_too_large =
      more == digits_of_nanoseconds && number > largest; // texts of the same length
  if (!is_known || number.front() == '0' || is_too_large)
    return std::nullopt;
  return std::chrono::nanoseconds(std::stoll(number) *
                                  powerOfTen(digits_of_nanoseconds - more));
}

/** \brief Files with the times in their names.
 * \param[out] without the first name without a time
 * \return fewer than there are files if some have none
 */
std::vector<std::pair<std::chrono::nanoseconds, std::string>>
withStamps(const std::vector<std::string>& paths, std::string& without)
{
  std::vector<std::pair<std::chrono::nanoseconds, std::string>> files;
  for (const std::string& path : paths)
    if (const std::optional<std::chrono::nanoseconds> stamp = stampOfName(path))
      files.emplace_back(*stamp, path);
    else if (without.empty())
      without = path;
  return files;
}

} // namespace

std::optional<std::chrono::nanoseconds>
stampOfName(const std::string& path)
{
  const std::string stem = stemOf(path);
  const std::size_t before = stem.find_last_not_of(digits);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  const std::string last = stem.substr(begin);
  if (begin == 0 || stem[before] != '.')
    return stampOfInteger(last);
  const std::size_t before_whole = stem.substr(0, before).find_last_not_of(digits);
  const std::size_t whole = before_whole == std::string::npos ? 0 : before_whole + 1;
  return stampOfSeconds(stem.substr(whole, before - whole), last);
}

StampsOfFiles
stampsOfNames(const std::vector<std::string>& paths)
{
  std::string without;
  const auto files = withStamps(paths, without);
  if (files.size() < paths.size())
    return {{},
            2 * files.size() <= paths.size()
                ? ""
                : "the times in the names are left out, as '" + without + "' has none"};
  std::vector<std::chrono::nanoseconds> stamps;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (i > 0 && files[i].first <= stamps.back())
      return {{},
              "the times in the names are left out, as that of '" + paths[i] +
                  "' is not later than that of '" + paths[i - 1] + "'"};
    stamps.push_back(files[i].first);
  }
  return {stamps, ""};
}

void
sortByStamp(std::vector<std::string>& paths)
{
  std::string without;
  auto files = withStamps(paths, without);
  if (files.size() < paths.size())
    return;
  std::sort(files.begin(), files.end());
  for (std::size_t i = 0; i < paths.size(); ++i)
    paths[i] = std::move(files[i].second);
}

} // namespace clouds
} // namespace pcl_ext
