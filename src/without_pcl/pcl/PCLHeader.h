// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

namespace pcl {

struct PCLHeader {
  std::uint32_t seq = 0;
  std::uint64_t stamp = 0; ///< microseconds since 1970
  std::string frame_id;
};

} // namespace pcl
