// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/PCLHeader.h>

#include <cstdint>
#include <string>
#include <vector>

namespace pcl {

struct PCLPointField {
  std::string name;
  std::uint32_t offset = 0; ///< within a point, bytes
  std::uint8_t datatype = 0;
  std::uint32_t count = 0;

  enum PointFieldTypes {
    INT8 = 1,
    UINT8 = 2,
    INT16 = 3,
    UINT16 = 4,
    INT32 = 5,
    UINT32 = 6,
    FLOAT32 = 7,
    FLOAT64 = 8
  };
};

struct PCLPointCloud2 {
  PCLHeader header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::vector<PCLPointField> fields;
  std::uint8_t is_bigendian = 0;
  std::uint32_t point_step = 0; ///< bytes
  std::uint32_t row_step = 0;   ///< bytes
  std::vector<std::uint8_t> data;
  std::uint8_t is_dense = 0;
};

} // namespace pcl
