// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/bag_place_reader.h"

#include "clouds/point_fields.h"
#include "clouds/usual_fields.h"
#include "console/throw_unless_ok.h"
#include "inputs/point_cloud_conversions.h"

#include <cstddef>
#include <exception>
#include <string>
#include <vector>

namespace pcl_ext::tools {

using recording::McapChannel;
using recording::RecordingStatus;

namespace {

/** \brief Gives fields their usual names, and packs separate channels of a colour.
 * \return what the user is to know of it, a line each
 */
std::vector<std::string>
makeUsual(bool packs_colours, InputCloud& input)
{
  pcl::PCLPointCloud2& cloud = input.cloud;
  std::vector<std::string> remarks;
  clouds::nameUsually(cloud, remarks);
  const std::size_t size = std::size_t{cloud.width} * cloud.height;
  const bool has_gaps = size == 0 || cloud.point_step == 0 ||
                        cloud.data.size() / cloud.point_step != size ||
                        cloud.data.size() % cloud.point_step != 0;
  if (packs_colours && !has_gaps)
    input.colour_remark =
        clouds::packColours(cloud, false, input.colour_scale, remarks);
  return remarks;
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
    cloud.colour_remark.clear();
    cloud.remark = message.is_bigendian == clouds::isBigEndianMachine()
                       ? ""
                       : "the bytes of its numbers are in the other order; messages of "
                         "decode have that of this machine";
    toCloud(message, cloud.cloud);
    for (const std::string& remark : makeUsual(packs_colours, cloud))
      cloud.remark += (cloud.remark.empty() ? "" : "; ") + remark;
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

} // namespace pcl_ext::tools
