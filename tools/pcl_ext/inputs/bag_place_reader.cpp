// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/bag_place_reader.h"

#include "console/throw_unless_ok.h"
#include "inputs/point_cloud_conversions.h"

#include <exception>

namespace pcl_ext {
namespace tools {

using recording::McapChannel;
using recording::RecordingStatus;

bool
hasClouds(const McapChannel& channel)
{
  return recording::isPointCloud(channel) || recording::isRos1PointCloud(channel);
}

void
readCloud(const McapChannel& channel,
          InputCloud& cloud,
          recording::PointCloudMessage& message)
{
  const std::vector<std::uint8_t>& bytes = cloud.message.bytes;
  try {
    throwUnlessOk(recording::readPointCloud(
        bytes.data(), bytes.size(), false, message, recording::encodingOf(channel)));
    cloud.stamp = message.stamp;
    toCloud(message, cloud.cloud);
  }
  catch (const std::exception& error) {
    cloud.failure = error.what();
  }
}

BagPlaceReader::BagPlaceReader(const std::string& path)
{
  throwUnlessOk(reader_.open(path));
}

void
BagPlaceReader::read(InputCloud& cloud)
{
  cloud.is_unread = false;
  const recording::BagEntry& entry = reader_.index()[cloud.place];
  if (const RecordingStatus status = reader_.read(entry, cloud.message); status.ok())
    readCloud(reader_.channels()[entry.channel], cloud, message_);
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
