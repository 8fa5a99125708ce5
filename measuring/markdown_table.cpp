// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "measuring/markdown_table.h"

#include <algorithm>
#include <iomanip>
#include <ostream>
#include <sstream>

namespace pcl_ext {
namespace measuring {

std::string
formatted(double value, int digits)
{
  std::ostringstream stream;
  stream << std::fixed << std::setprecision(digits) << value;
  std::string text = stream.str();
  const std::size_t first_digit = text.front() == '-' ? 1 : 0;
  const std::size_t point = std::min(text.find('.'), text.size());
  for (std::size_t i = point; i > first_digit + 3; i -= 3)
    text.insert(i - 3, ",");
  return text;
}

namespace {

/** \brief Characters of a text in UTF-8. */
std::size_t
charactersOf(const std::string& text)
{
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](unsigned char byte) {
        return (byte & 0xc0) != 0x80;
      }));
}

} // namespace

void
MarkdownTable::print(std::ostream& output) const
{
  std::vector<std::size_t> widths;
  for (const Row& row : rows_) {
    widths.resize(std::max(widths.size(), row.size()), 3);
    for (std::size_t i = 0; i < row.size(); ++i)
      widths[i] = std::max(widths[i], charactersOf(row[i]));
  }
  for (const Row& row : rows_) {
    output << '|';
    for (std::size_t i = 0; i < widths.size(); ++i) {
      const std::string text = i < row.size() ? row[i] : std::string();
      output << ' ' << text << std::string(widths[i] - charactersOf(text), ' ') << " |";
    }
    output << '\n';
    if (&row == &rows_.front()) {
      output << '|';
      for (const std::size_t width : widths)
        output << std::string(width + 2, '-') << '|';
      output << '\n';
    }
  }
  output << '\n';
}

} // namespace measuring
} // namespace pcl_ext
