// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/sqlite/bag_database.h"

/** \file
 * \brief In place of bag_database.cpp where there is no libsqlite3.
 */

namespace pcl_ext::PCL_EXT_ABI::recording::sqlite {

class BagDatabase::Implementation {};

BagDatabase::BagDatabase(InputFile&& file) : BagFile(std::move(file)) {}
BagDatabase::~BagDatabase() = default;

RecordingStatus
BagDatabase::findContents(const ChannelFilter& /* wants */,
                          FileContents& /* contents */)
{
  return {RecordingCode::NotARecording,
          "'" + file().path() +
              "' is a bag of the storage sqlite3, and this program was built without "
              "libsqlite3: convert it to MCAP with 'ros2 bag convert', or build where "
              "libsqlite3-dev is installed"};
}

std::string
BagDatabase::read(const MessagePlace& /* place */,
                  McapMessage& /* message */,
                  std::uint16_t& /* channel_id */)
{
  return "there is no libsqlite3";
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::sqlite
