// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/mcap_place_reader.h"

#include "console/throw_unless_ok.h"
#include "inputs/point_cloud_conversions.h"

#include <exception>

namespace pcl_ext {
namespace tools {

using recording::RecordingStatus;

void
readCloud(InputCloud& cloud, recording::PointCloudMessage& message)
{
  const RecordingStatus status = recording::readPointCloud(
      cloud.message.bytes.data(), cloud.message.bytes.size(), false, message);
  if (!status.ok()) {
    cloud.failure = status.message();
    return;
  }
  cloud.stamp = message.stamp;
  try {
    toCloud(message, cloud.cloud);
  }
  catch (const std::exception& error) {
    cloud.failure = error.what();
  }
}

McapPlaceReader::McapPlaceReader(const std::string& path)
{
  throwUnlessOk(reader_.open(path));
}

void
McapPlaceReader::read(InputCloud& cloud)
{
  cloud.is_unread = false;
  if (const RecordingStatus status =
          reader_.read(reader_.index()[cloud.place], cloud.message);
      status.ok())
    readCloud(cloud, message_);
  else
    cloud.failure = status.message();
}

bool
McapPlaceReader::read(std::size_t place, recording::McapMessage& message)
{
  return reader_.read(reader_.index()[place], message).ok();
}

} // namespace tools
} // namespace pcl_ext
