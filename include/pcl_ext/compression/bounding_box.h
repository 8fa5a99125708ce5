// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <array>

namespace pcl_ext {
namespace io {

/** \brief An axis-aligned box, metres; both ends are included. In world coordinates
 * unless something else is said. */
struct BoundingBox {
  std::array<double, 3> min{};
  std::array<double, 3> max{};
};

} // namespace io
} // namespace pcl_ext
