// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <pcl/impl/point_types.hpp>
#include <pcl/register_point_struct.h>
#include <pcl/types.h>

namespace pcl_ext::PCL_EXT_ABI {

/** \addtogroup common
 * @{ */

/** \brief A point with a colour and an intensity, which PCL has no type for. */
struct EIGEN_ALIGN16 PointXYZRGBI {
  PCL_ADD_POINT4D; // metres
  PCL_ADD_RGB;
  float intensity = 0.0f;
  PCL_MAKE_ALIGNED_OPERATOR_NEW

  /** \brief A black point at the origin. */
  PointXYZRGBI() : data{0.0f, 0.0f, 0.0f, 1.0f}, rgba(0xff000000u) {}
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI

POINT_CLOUD_REGISTER_POINT_STRUCT(pcl_ext::PointXYZRGBI,
                                  (float, x, x)(float, y, y)(float, z, z)(
                                      float, rgb, rgb)(float, intensity, intensity))
