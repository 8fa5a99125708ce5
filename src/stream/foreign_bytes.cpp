// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/foreign_bytes.h"

#include <algorithm>
#include <array>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

struct Format {
  const char* beginning;
  const char* description;
};

constexpr std::array<Format, 7> formats = {{
    {"<PCL-OCT-COMPRESSED>",
     "a stream of PCL's own class: decode it with "
     "pcl::io::OctreePointCloudCompression"},
    {"<PCL-ORG-COMPRESSED>",
     "a stream of pcl::io::OrganizedPointCloudCompression: decode it with that class"},
    {"# .PCD", "a PCD file: read it with pcl::io::loadPCDFile"},
    {"VERSION ", "a PCD file: read it with pcl::io::loadPCDFile"},
    {"ply", "a PLY file: read it with pcl::io::loadPLYFile"},
    {"#ROSBAG", "a ROS bag"},
    {"\x89MCAP", "an MCAP recording"},
}};

bool
isTextCharacter(std::uint8_t byte)
{
  return (byte >= 0x20 && byte < 0x7f) || (byte >= '\t' && byte <= '\r');
}

} // namespace

std::string
describeForeignBytes(const std::uint8_t* bytes, std::size_t size)
{
  for (const Format& format : formats) {
    const std::string beginning = format.beginning;
    if (size >= beginning.size() &&
        std::equal(
            beginning.begin(), beginning.end(), bytes, [](char a, std::uint8_t b) {
              return static_cast<std::uint8_t>(a) == b;
            }))
      return format.description;
  }
  constexpr std::size_t least_text = 8; // fewer random bytes may look like text
  if (size >= least_text && std::all_of(bytes, bytes + size, isTextCharacter))
    return "text";
  return "";
}

} // namespace pcl_ext::PCL_EXT_ABI::io
