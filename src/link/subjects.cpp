// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "link/subjects.h"

#include <charconv>

namespace pcl_ext::PCL_EXT_ABI::link {

namespace {

constexpr std::string_view digits = "0123456789ABCDEF";
constexpr std::string_view frames_end = ".frames";

bool
isPlain(char character)
{
  return (character >= 'a' && character <= 'z') ||
         (character >= 'A' && character <= 'Z') ||
         (character >= '0' && character <= '9') || character == '-' ||
         character == '_' || character == '/';
}

} // namespace

std::string
escaped(std::string_view text)
{
  std::string result;
  for (const char character : text) {
    if (isPlain(character)) {
      result += character;
      continue;
    }
    const auto byte = static_cast<unsigned char>(character);
    result += '%';
    result += digits[byte / digits.size()];
    result += digits[byte % digits.size()];
  }
  return result;
}

std::optional<std::string>
unescaped(std::string_view escaped_text)
{
  std::string result;
  for (std::size_t i = 0; i < escaped_text.size(); ++i) {
    char character = escaped_text[i];
    if (character == '%') {
      if (i + 2 >= escaped_text.size())
        return std::nullopt;
      const std::size_t high = digits.find(escaped_text[i + 1]);
      const std::size_t low = digits.find(escaped_text[i + 2]);
      if (high == std::string_view::npos || low == std::string_view::npos)
        return std::nullopt;
      character = static_cast<char>(high * digits.size() + low);
      i += 2;
      // Else one name would have several subjects.
      if (isPlain(character))
        return std::nullopt;
    }
    else if (!isPlain(character))
      return std::nullopt;
    result += character;
  }
  return result;
}

std::string
framesSubject(const std::string& site, const std::string& stream)
{
  return site + "." + escaped(stream) + std::string(frames_end);
}

std::string
requestsSubject(const std::string& site, const std::string& stream)
{
  return site + "." + escaped(stream) + ".requests";
}

std::string
echoSubject(const std::string& site, std::uint64_t publisher)
{
  return site + "." + std::to_string(publisher) + ".echo";
}

std::optional<FramesSubject>
parseFramesSubject(const std::string& site, std::string_view subject)
{
  if (subject.substr(0, site.size()) != site ||
      subject.substr(site.size(), 1) != std::string_view("."))
    return std::nullopt;
  subject.remove_prefix(site.size() + 1);
  const std::size_t end = subject.find('.');
  if (end == 0 || end == std::string_view::npos ||
      subject.substr(end, frames_end.size()) != frames_end)
    return std::nullopt;
  const std::optional<std::string> stream = unescaped(subject.substr(0, end));
  if (!stream || stream->size() > longest_stream_name)
    return std::nullopt;
  FramesSubject result;
  result.stream = *stream;
  subject.remove_prefix(end + frames_end.size());
  if (subject.empty())
    return result;
  unsigned int partition = 0;
  const char* const last = subject.data() + subject.size();
  const auto parsed = std::from_chars(subject.data() + 1, last, partition);
  if (subject.front() != '.' || parsed.ptr != last || parsed.ec != std::errc())
    return std::nullopt;
  result.partition = partition;
  return result;
}

std::optional<SiteStream>
siteStreamOf(std::string_view subject)
{
  const std::string site(subject.substr(0, subject.find('.')));
  const auto parsed = parseFramesSubject(site, subject);
  if (!parsed)
    return std::nullopt;
  return SiteStream{site, parsed->stream, parsed->partition};
}

} // namespace pcl_ext::PCL_EXT_ABI::link
