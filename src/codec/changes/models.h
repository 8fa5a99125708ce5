// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/fast/models.h"
#include "codec/supplement/residuals.h"

#include <array>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace changes {

/** \brief Models of frames of changes, at first as at an I-frame. */
struct Models {
  std::array<rans::NibbleModel, 16> octant; ///< by change history
  std::array<rans::NibbleModel, 9> cell;    ///< by the number of likely cells
  fast::MaskModels several;                 ///< masks of several octants or cells
  fast::NodeModels node;                    ///< of the octree of new blocks
  std::array<rans::NibbleModel, 2> change;  ///< by whether it has changed recently
  supplement::ResidualModels appeared;
  rans::NibbleModel lengths; ///< of large numbers
};

} // namespace changes
} // namespace pcl_ext::PCL_EXT_ABI::io
