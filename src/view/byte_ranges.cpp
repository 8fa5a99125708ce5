// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/byte_ranges.h"

#include <algorithm>
#include <charconv>

namespace pcl_ext::PCL_EXT_ABI::view {

namespace {

std::string_view
trimmed(std::string_view text)
{
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos)
    return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/** \brief A number without sign; nothing for other texts. */
std::optional<std::uint64_t>
numberOf(std::string_view text)
{
  std::uint64_t number = 0;
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, number);
  if (text.empty() || result.ec != std::errc() || result.ptr != end)
    return std::nullopt;
  return number;
}

/** \brief One range, whether it is in the file or not; nothing if it is none. */
std::optional<ByteRange>
parseRange(std::string_view text, std::uint64_t size)
{
  const std::size_t dash = text.find('-');
  if (dash == std::string_view::npos)
    return std::nullopt;
  const std::string_view before = text.substr(0, dash);
  const std::string_view after = text.substr(dash + 1);
  const std::optional<std::uint64_t> from = numberOf(before);
  const std::optional<std::uint64_t> to = numberOf(after);
  if (before.empty() && to) // the last bytes
    return *to == 0 ? ByteRange{size, size}
                    : ByteRange{size - std::min(*to, size), size};
  if (!from || (!after.empty() && (!to || *to < *from)))
    return std::nullopt;
  return ByteRange{*from, to.value_or(size)};
}

} // namespace

std::optional<std::vector<ByteRange>>
parseByteRanges(std::string_view header, std::uint64_t size)
{
  constexpr std::string_view unit = "bytes=";
  if (header.substr(0, unit.size()) != unit)
    return std::nullopt;
  header.remove_prefix(unit.size());
  std::vector<ByteRange> ranges;
  std::size_t count = 0;
  while (!header.empty()) {
    const std::size_t comma = std::min(header.find(','), header.size());
    const std::string_view text = trimmed(header.substr(0, comma));
    header.remove_prefix(std::min(comma + 1, header.size()));
    if (text.empty())
      continue;
    std::optional<ByteRange> range = parseRange(text, size);
    if (!range || ++count > max_byte_ranges)
      return std::nullopt;
    if (range->first >= size)
      continue;
    range->last = std::min(range->last, size - 1);
    ranges.push_back(*range);
  }
  if (count == 0)
    return std::nullopt;
  return ranges;
}

std::string
contentRange(const ByteRange& range, std::uint64_t size)
{
  return "bytes " + std::to_string(range.first) + "-" + std::to_string(range.last) +
         "/" + std::to_string(size);
}

} // namespace pcl_ext::PCL_EXT_ABI::view
