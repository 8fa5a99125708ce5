// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <iosfwd>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief A number with so many digits after the point, thousands apart: 1,234.5 */
std::string
formatted(double value, int digits);

/** \brief A table that is filled row by row and printed as Markdown, columns
 * aligned. */
class MarkdownTable {
public:
  using Row = std::vector<std::string>;

  explicit MarkdownTable(Row header) : rows_{std::move(header)} {}

  void
  addRow(Row row)
  {
    rows_.push_back(std::move(row));
  }

  void
  print(std::ostream& output) const;

private:
  std::vector<Row> rows_; ///< the first is the header
};

} // namespace measuring
} // namespace pcl_ext
