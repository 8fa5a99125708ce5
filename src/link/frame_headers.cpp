// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "link/frame_headers.h"

#include "link/subjects.h"

#include <array>
#include <charconv>

namespace pcl_ext::PCL_EXT_ABI::link {

namespace {

/** \brief Nanoseconds, the year 2116: differences of times must not overflow. */
constexpr std::int64_t farthest_time = std::int64_t{1} << 62;

/** \brief Reads a number and the space after it, if it is not the last one. */
template <typename NumberT>
bool
takeNumber(std::string_view& text, int base, NumberT& number)
{
  const char* const end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, number, base);
  if (parsed.ec != std::errc() || (parsed.ptr != end && *parsed.ptr != ' '))
    return false;
  text.remove_prefix(static_cast<std::size_t>(parsed.ptr - text.data()));
  if (text.empty())
    return true;
  text.remove_prefix(1);
  return !text.empty();
}

} // namespace

std::string
writeFrameHeader(const FrameHeader& header)
{
  constexpr std::size_t longest = 64;
  constexpr int hexadecimal = 16;
  std::array<char, longest> publisher{};
  const auto written = std::to_chars(
      publisher.data(), publisher.data() + longest, header.publisher, hexadecimal);
  return "1 " + std::string(publisher.data(), written.ptr) + " " +
         std::to_string(header.number) + " " + std::to_string(header.time.count());
}

std::optional<FrameHeader>
parseFrameHeader(std::string_view text)
{
  constexpr int hexadecimal = 16;
  constexpr int decimal = 10;
  unsigned int version = 0;
  FrameHeader header;
  std::int64_t time = 0;
  if (!takeNumber(text, decimal, version) || version != 1 ||
      !takeNumber(text, hexadecimal, header.publisher) ||
      !takeNumber(text, decimal, header.number) || header.number == 0 ||
      !takeNumber(text, decimal, time) || !text.empty() || time < -farthest_time ||
      time > farthest_time)
    return std::nullopt;
  header.time = Time(time);
  return header;
}

std::string
writeMetadata(const std::string& key, const std::string& value)
{
  return escaped(key) + "=" + escaped(value);
}

std::optional<std::pair<std::string, std::string>>
parseMetadata(std::string_view text)
{
  const std::size_t middle = text.find('=');
  if (middle == std::string_view::npos)
    return std::nullopt;
  const auto key = unescaped(text.substr(0, middle));
  const auto value = unescaped(text.substr(middle + 1));
  if (!key || !value)
    return std::nullopt;
  return std::pair(*key, *value);
}

} // namespace pcl_ext::PCL_EXT_ABI::link
