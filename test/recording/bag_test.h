// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "recording/bag_reader.h"
#include "support/recorded_streams.h"

#include <gtest/gtest.h>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

/** \brief A test with a folder and a reader of the bags in it. */
class BagTest : public ::testing::Test {
protected:
  /** \brief Writes a file, and opens it. */
  RecordingStatus
  open(const std::string& name, const Bytes& bytes)
  {
    writeBytes(folder / name, bytes);
    return reader.open(folder / name);
  }

  const TestFolder folder;
  BagReader reader;
  McapMessage message;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording::test
