#pragma once

#include <pcl/point_types.h>

namespace pcl_ext {

/** \brief True if the point type has a field `intensity` registered with PCL. */
template <typename PointT>
constexpr bool has_intensity_field = pcl::traits::has_intensity<PointT>::value;

/** \brief The point's own intensity, in its unit, or `absent` if its type has none. */
template <typename PointT>
float
nativeIntensity(const PointT& point, float absent)
{
  if constexpr (has_intensity_field<PointT>)
    return static_cast<float>(point.intensity);
  else
    return absent;
}

} // namespace pcl_ext
