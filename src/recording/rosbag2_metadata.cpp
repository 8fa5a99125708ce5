// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/rosbag2_metadata.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

namespace {

/** \brief A line without its indentation. A list's dash belongs to the indentation of
 * the first key after it. */
struct Line {
  std::size_t begin = 0;  // in the text
  std::size_t indent = 0; // columns before the key
  bool is_item = false;   // there is a dash before the key
  std::size_t key = 0;    // where the key begins, in the text
  std::size_t end = 0;    // of the line, in the text
};

std::vector<Line>
linesOf(const std::string& text)
{
  std::vector<Line> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    Line line;
    line.begin = line.key = begin;
    line.end = std::min(text.find('\n', begin), text.size());
    while (line.key < line.end && (text[line.key] == ' ' || text[line.key] == '-')) {
      line.is_item |= text[line.key] == '-';
      ++line.key;
    }
    line.indent = line.key - line.begin;
    if (line.key < line.end)
      lines.push_back(line);
    begin = line.end + 1;
  }
  return lines;
}

/** \brief A text in single or double quotes.
 * \param[in] at index of the first quote
 */
std::string
unquoted(const std::string& text, std::size_t at)
{
  const char quote = text[at++];
  std::string value;
  while (at < text.size()) {
    const char character = text[at++];
    const char next = at < text.size() ? text[at] : '\0';
    if (character == quote && (quote == '"' || next != '\''))
      return value;
    if (character == '\n') { // a line that was folded
      value.erase(value.find_last_not_of(' ') + 1);
      std::size_t empty_lines = 0;
      for (; at < text.size() && (text[at] == ' ' || text[at] == '\n'); ++at)
        empty_lines += text[at] == '\n' ? 1 : 0;
      value += empty_lines == 0 ? " " : std::string(empty_lines, '\n');
    }
    else if (quote == '"' && character == '\\') {
      ++at;
      if (next == '\n') // and the blanks at the beginning of the next line
        at = std::min(text.find_first_not_of(' ', at), text.size());
      else
        value += next == 'n' ? '\n' : next == 't' ? '\t' : next;
    }
    else {
      value += character;
      at += character == quote ? 1 : 0; // it is written twice
    }
  }
  return value;
}

/** \brief The lines below a key, without their common indentation. */
std::string
blockBelow(const std::string& text, const std::vector<Line>& lines, std::size_t key)
{
  const auto columnOf = [&text](const Line& line) {
    return text.find_first_not_of(' ', line.begin) - line.begin;
  };
  std::string block;
  std::size_t first_column = 0;
  for (std::size_t i = key + 1; i < lines.size(); ++i) {
    const Line& line = lines[i];
    const std::size_t column = columnOf(line);
    const std::size_t key_column = lines[key].indent;
    if (column < key_column || (column == key_column && !line.is_item))
      break;
    if (block.empty())
      first_column = column;
    const std::size_t begin = line.begin + std::min(column, first_column);
    block += (block.empty() ? "" : "\n") + text.substr(begin, line.end - begin);
  }
  return block;
}

std::string
valueOf(const std::string& text, const std::vector<Line>& lines, std::size_t key)
{
  const Line& line = lines[key];
  const std::size_t colon = std::min(text.find(':', line.key), line.end);
  const std::size_t begin = text.find_first_not_of(' ', std::min(colon + 1, line.end));
  if (begin >= line.end || text[begin] == '|' || text[begin] == '>')
    return blockBelow(text, lines, key);
  if (text[begin] == '"' || text[begin] == '\'')
    return unquoted(text, begin);
  const std::string value = text.substr(begin, line.end - begin);
  return value == "[]" || value == "~" || value == "null" ? std::string() : value;
}

} // namespace

std::map<std::string, std::string>
readOfferedQos(const std::string& metadata)
{
  std::string text = metadata;
  text.erase(std::remove(text.begin(), text.end(), '\r'), text.end());
  const std::vector<Line> lines = linesOf(text);
  const auto isKey = [&](const Line& line, const std::string& name) {
    return text.compare(line.key, name.size(), name) == 0 &&
           line.end - line.key >= name.size();
  };
  std::map<std::string, std::string> profiles;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!isKey(lines[i], "topic_metadata:") || i + 1 == lines.size())
      continue;
    const std::size_t indent = lines[i + 1].indent; // of the keys in it
    if (indent <= lines[i].indent)
      continue;
    std::string topic;
    std::string qos;
    std::size_t k = i + 1;
    for (; k < lines.size() && lines[k].indent >= indent; ++k) {
      if (lines[k].indent > indent || lines[k].is_item)
        continue;
      if (isKey(lines[k], "name:"))
        topic = valueOf(text, lines, k);
      else if (isKey(lines[k], "offered_qos_profiles:"))
        qos = valueOf(text, lines, k);
    }
    if (!topic.empty() && !qos.empty())
      profiles[topic] = qos;
    i = k - 1; // each line is read once
  }
  return profiles;
}

std::vector<std::string>
readFileNames(const std::string& metadata)
{
  std::string text = metadata;
  text.erase(std::remove(text.begin(), text.end(), '\r'), text.end());
  const std::vector<Line> lines = linesOf(text);
  const std::string key = "relative_file_paths:";
  std::vector<std::string> names;
  std::size_t i = 0;
  while (i < lines.size() && text.compare(lines[i].key, key.size(), key) != 0)
    ++i;
  for (++i; i < lines.size() && lines[i].is_item; ++i) {
    const char first = text[lines[i].key];
    const std::string path =
        first == '"' || first == '\''
            ? unquoted(text, lines[i].key)
            : text.substr(lines[i].key, lines[i].end - lines[i].key);
    names.push_back(path.substr(path.find_last_of('/') + 1)); // npos + 1 is 0
  }
  return names;
}

std::string
readValue(const std::string& metadata, const std::string& key)
{
  std::string text = metadata;
  text.erase(std::remove(text.begin(), text.end(), '\r'), text.end());
  const std::vector<Line> lines = linesOf(text);
  const auto found = std::find_if(lines.begin(), lines.end(), [&](const Line& line) {
    return text.compare(line.key, key.size() + 1, key + ':') == 0;
  });
  return found == lines.end()
             ? std::string()
             : valueOf(text, lines, static_cast<std::size_t>(found - lines.begin()));
}

bool
hasNamedPolicies(const std::string& qos)
{
  const std::string key = "reliability:";
  const std::size_t begin = qos.find(key);
  const std::size_t value = begin == std::string::npos
                                ? begin
                                : qos.find_first_not_of(' ', begin + key.size());
  return value != std::string::npos &&
         std::isalpha(static_cast<unsigned char>(qos[value])) != 0;
}

std::string
withNamedPolicies(const std::string& qos)
{
  const std::map<std::string, std::vector<std::string>> names = {
      {"history", {"system_default", "keep_last", "keep_all", "unknown"}},
      {"reliability",
       {"system_default", "reliable", "best_effort", "unknown", "best_available"}},
      {"durability",
       {"system_default", "transient_local", "volatile", "unknown", "best_available"}},
      {"liveliness",
       {"system_default",
        "automatic",
        "manual_by_node",
        "manual_by_topic",
        "unknown",
        "best_available"}}};
  std::string named;
  std::size_t copied = 0;
  for (const Line& line : linesOf(qos)) {
    const std::size_t colon = std::min(qos.find(':', line.key), line.end);
    const auto policy = names.find(qos.substr(line.key, colon - line.key));
    const std::size_t value = qos.find_first_not_of(' ', colon + 1);
    if (policy == names.end() || value >= line.end || value + 1 < line.end)
      continue;
    const std::size_t number = static_cast<std::size_t>(qos[value]) - '0';
    if (number >= policy->second.size()) // no digit either
      continue;
    named += qos.substr(copied, value - copied) + policy->second[number];
    copied = line.end;
  }
  return named + qos.substr(copied);
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
