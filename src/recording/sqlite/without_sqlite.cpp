// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/sqlite/bag_database.h"

/** \file
 * \brief In place of bag_database.cpp where there is no libsqlite3.
 */

namespace pcl_ext {
namespace recording {
namespace sqlite {

class BagDatabase::Implementation {};

BagDatabase::BagDatabase() = default;
BagDatabase::~BagDatabase() = default;

RecordingStatus
BagDatabase::open(const InputFile& file,
                  const McapReader::ChannelFilter& /* wants */,
                  mcap::FileContents& /* contents */)
{
  return {RecordingCode::NotARecording,
          "'" + file.path() +
              "' is a bag of the storage sqlite3, and this program was built without "
              "libsqlite3: convert it to MCAP with 'ros2 bag convert', or build where "
              "libsqlite3-dev is installed"};
}

std::string
BagDatabase::read(std::uint64_t /* row */,
                  McapMessage& /* message */,
                  std::uint16_t& /* channel_id */)
{
  return "there is no libsqlite3";
}

} // namespace sqlite
} // namespace recording
} // namespace pcl_ext
