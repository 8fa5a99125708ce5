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
constexpr std::size_t digits_of_date = 8;        // YYYYMMDD
constexpr std::size_t digits_of_time_of_day = 6; // hhmmss

std::int64_t
powerOfTen(std::size_t exponent)
{
  std::int64_t power = 1;
  while (exponent-- > 0)
    power *= 10;
  return power;
}

std::chrono::nanoseconds
fractionOfSecond(const std::string& fraction)
{
  return std::chrono::nanoseconds(
      fraction.empty()
          ? 0
          : std::stoll(fraction) * powerOfTen(digits_of_nanoseconds - fraction.size()));
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
  return std::chrono::seconds(std::stoll(whole)) + fractionOfSecond(fraction);
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

/** \brief Days from 1970-01-01 to a date of the Gregorian calendar, from 1970 on. */
std::int64_t
daysSince1970(std::int64_t year, std::int64_t month, std::int64_t day)
{
  // Years that begin in March have the leap day at their end.
  const std::int64_t from_march = (month + 9) % 12;
  const std::int64_t years = month <= 2 ? year - 1 : year;
  constexpr std::int64_t until_1970 = 719468; // from the 1st of March of the year 0
  return 365 * years + years / 4 - years / 100 + years / 400 +
         (153 * from_march + 2) / 5 + day - 1 - until_1970;
}

/** \brief Date, time of day and a fraction of a second, or nothing if that is no
 * time. */
std::optional<std::chrono::nanoseconds>
stampOfCalendar(const std::string& date,
                const std::string& time_of_day,
                const std::string& fraction)
{
  const auto number = [](const std::string& text, std::size_t begin, std::size_t size) {
    return std::stoll(text.substr(begin, size));
  };
  const std::int64_t year = number(date, 0, 4);
  const std::int64_t month = number(date, 4, 2);
  const std::int64_t day = number(date, 6, 2);
  const std::int64_t hour = number(time_of_day, 0, 2);
  const std::int64_t minute = number(time_of_day, 2, 2);
  const std::int64_t second = number(time_of_day, 4, 2);
  constexpr std::int64_t last_year = 2261; // of which 64 bits have all nanoseconds
  if (year < 1970 || year > last_year || month < 1 || month > 12 || day < 1 ||
      hour > 23 || minute > 59 || second > 59)
    return std::nullopt;
  const std::int64_t days = daysSince1970(year, month, 1);
  const std::int64_t days_of_month =
      daysSince1970(month == 12 ? year + 1 : year, month % 12 + 1, 1) - days;
  if (day > days_of_month)
    return std::nullopt;
  return std::chrono::hours(24 * (days + day - 1) + hour) +
         std::chrono::minutes(minute) + std::chrono::seconds(second) +
         fractionOfSecond(fraction);
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

/** \brief Removes the digits that a text ends with.
 * \return these
 */
std::string
takeLastDigits(std::string& text)
{
  const std::size_t before = text.find_last_not_of(digits);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  std::string last = text.substr(begin);
  text.resize(begin);
  return last;
}

} // namespace

std::optional<std::chrono::nanoseconds>
stampOfName(const std::string& path)
{
  std::string before = stemOf(path);
  std::string whole = takeLastDigits(before);
  std::string fraction;
  const bool has_point = !before.empty() && before.back() == '.';
  if (has_point) {
    before.pop_back();
    fraction = std::exchange(whole, takeLastDigits(before));
  }
  if (whole.size() == digits_of_time_of_day && !before.empty() &&
      before.back() == 'T' && has_point == !fraction.empty() &&
      fraction.size() <= digits_of_nanoseconds) {
    before.pop_back();
    if (const std::string date = takeLastDigits(before); date.size() == digits_of_date)
      return stampOfCalendar(date, whole, fraction);
  }
  return has_point ? stampOfSeconds(whole, fraction) : stampOfInteger(whole);
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

bool
isNameOfFrame(const std::string& path)
{
  std::string number = stemOf(path);
  if (stampOfName(path))
    number.resize(std::min(number.find('_'), number.size()));
  constexpr std::size_t fewest_digits = 6;
  constexpr std::size_t most_digits = 9;
  return (number.size() == fewest_digits ||
          (number.size() > fewest_digits && number.size() <= most_digits &&
           number[0] != '0')) &&
         number.find_first_not_of(digits) == std::string::npos;
}

void
sortByStamp(std::vector<std::string>& paths)
{
  if (std::all_of(paths.begin(), paths.end(), isNameOfFrame))
    return;
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
