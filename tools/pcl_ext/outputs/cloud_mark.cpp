// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outputs/cloud_mark.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <string>
#include <string_view>

namespace pcl_ext::tools {

namespace {

constexpr std::string_view pcd_mark = "# written by pcl_ext\n";
constexpr std::string_view ply_mark = "comment written by pcl_ext\n";

bool
isPly(std::string_view head)
{
  return head.substr(0, 4) == "ply\n";
}

/** \brief Where the mark of a file is: behind its first line, of PLY behind the format,
 * which has to be the second one. */
std::size_t
placeOfMark(std::string_view head)
{
  std::size_t end = head.find('\n');
  if (end != std::string_view::npos && isPly(head))
    end = head.find('\n', end + 1);
  return end == std::string_view::npos ? head.size() : end + 1;
}

std::string_view
markOf(std::string_view head)
{
  return isPly(head) ? ply_mark : pcd_mark;
}

} // namespace

void
markAsOurs(std::vector<std::uint8_t>& file)
{
  const std::string head(file.begin(),
                         file.begin() + static_cast<std::ptrdiff_t>(
                                            std::min<std::size_t>(file.size(), 256)));
  const std::string_view mark = markOf(head);
  file.insert(file.begin() + static_cast<std::ptrdiff_t>(placeOfMark(head)),
              mark.begin(),
              mark.end());
}

bool
isOurs(const std::filesystem::path& file)
{
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error))
    return false;
  std::array<char, 256> start{};
  std::ifstream stream(file, std::ios::binary);
  stream.read(start.data(), start.size());
  const std::string_view head(start.data(), static_cast<std::size_t>(stream.gcount()));
  const std::string_view mark = markOf(head);
  return head.substr(placeOfMark(head), mark.size()) == mark;
}

} // namespace pcl_ext::tools
