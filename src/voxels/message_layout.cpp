// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/message_layout.h>

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::io {

std::size_t
bytesOf(const MessageLayout& layout)
{
  constexpr std::size_t of_numbers = 6; // number of fields, point_step, row_padding
  constexpr std::size_t of_field = 6;   // size of its name, type, count, offset
  std::size_t bytes = of_numbers;
  for (const PlacedField& field : layout.fields)
    bytes += field.name.size() + of_field;
  return bytes;
}

bool
isLayout(const MessageLayout& layout)
{
  const auto is_within = [&layout](const PlacedField& field) {
    return isField(field) && field.step == 0.0 &&
           field.offset + std::uint64_t{field.count} * sizeOf(field.type) <=
               layout.point_step;
  };
  return layout.point_step > 0 && layout.point_step <= most_point_step &&
         layout.row_padding <= most_row_padding &&
         bytesOf(layout) <= most_layout_bytes &&
         std::all_of(layout.fields.begin(), layout.fields.end(), is_within);
}

} // namespace pcl_ext::PCL_EXT_ABI::io
