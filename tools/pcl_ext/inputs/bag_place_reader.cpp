// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/bag_place_reader.h"

#include "clouds/file_text.h"
#include "clouds/point_fields.h"
#include "clouds/usual_fields.h"
#include "console/throw_unless_ok.h"
#include "inputs/point_cloud_conversions.h"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <string>
#include <vector>

namespace pcl_ext {
namespace tools {

using recording::McapChannel;
using recording::RecordingStatus;

namespace {

/** \brief Gives coordinates in capitals their usual names, if there are no others.
 * \return whether there are such */
bool
nameCoordinatesUsually(pcl::PCLPointCloud2& cloud)
{
  bool is_changed = false;
  for (pcl::PCLPointField& field : cloud.fields) {
    const std::string usual = clouds::lowerCase(field.name);
    if (!clouds::isCoordinateName(field.name) || usual == field.name ||
        std::any_of(cloud.fields.begin(),
                    cloud.fields.end(),
                    [&usual](const auto& other) { return other.name == usual; }))
      continue;
    field.name = usual;
    is_changed = true;
  }
  return is_changed;
}

/** \brief Packs separate channels of a colour, which are no fields to keep. */
void
packColours(InputCloud& cloud)
{
  pcl::PCLPointCloud2& points = cloud.cloud;
  const std::size_t size = std::size_t{points.width} * points.height;
  std::vector<std::string> remarks;
  if (size > 0 && points.point_step > 0 &&
      points.data.size() / points.point_step == size &&
      points.data.size() % points.point_step == 0)
    clouds::packColours(points, false, remarks);
  if (!remarks.empty())
    cloud.remark = remarks.front();
}

} // namespace

bool
hasClouds(const McapChannel& channel)
{
  return recording::isPointCloud(channel) || recording::isRos1PointCloud(channel);
}

void
readCloud(const McapChannel& channel,
          bool packs_colours,
          InputCloud& cloud,
          recording::PointCloudMessage& message)
{
  const std::vector<std::uint8_t>& bytes = cloud.message.bytes;
  try {
    throwUnlessOk(recording::readPointCloud(
        bytes.data(), bytes.size(), false, message, recording::encodingOf(channel)));
    cloud.stamp = message.stamp;
    cloud.remark = message.is_bigendian == clouds::isBigEndianMachine()
                       ? ""
                       : "the bytes of its numbers are in the other order; messages of "
                         "decode have that of this machine";
    toCloud(message, cloud.cloud);
    if (nameCoordinatesUsually(cloud.cloud))
      cloud.remark = "its fields X, Y, Z are taken as x, y, z";
    if (packs_colours)
      packColours(cloud);
  }
  catch (const std::exception& error) {
    cloud.failure = error.what();
  }
}

BagPlaceReader::BagPlaceReader(const std::string& path, bool packs_colours)
: packs_colours_(packs_colours)
{
  throwUnlessOk(reader_.open(path));
}

void
BagPlaceReader::read(InputCloud& cloud)
{
  cloud.is_unread = false;
  const recording::BagEntry& entry = reader_.index()[cloud.place];
  if (const RecordingStatus status = reader_.read(entry, cloud.message); status.ok())
    readCloud(reader_.channels()[entry.channel], packs_colours_, cloud, message_);
  else
    cloud.failure = status.message();
}

bool
BagPlaceReader::read(std::size_t place, recording::McapMessage& message)
{
  return reader_.read(reader_.index()[place], message).ok();
}

} // namespace tools
} // namespace pcl_ext
