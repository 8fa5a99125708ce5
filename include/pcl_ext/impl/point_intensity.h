// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_frame.h>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief True if the point type has a field `intensity` registered with PCL. */
template <typename PointT>
constexpr bool has_intensity_field = pcl::traits::has_intensity<PointT>::value;

/** \brief True if the point type has a field `rgb` or `rgba` registered with PCL. */
template <typename PointT>
constexpr bool has_colour_field = pcl::traits::has_color<PointT>::value;

/** \brief The intensity field of a point, or `absent` if its type has none. */
template <typename PointT>
float
nativeIntensity(const PointT& point, float absent)
{
  if constexpr (has_intensity_field<PointT>)
    return static_cast<float>(point.intensity);
  else
    return absent;
}

namespace detail {

/** \brief Converts a voxel intensity to the type of a point's field: rounded to the
 * nearest and clamped to the range of an integer type. */
template <typename FieldT>
FieldT
fieldValue(float intensity)
{
  if constexpr (std::is_integral<FieldT>::value) {
    constexpr auto lowest = static_cast<double>(std::numeric_limits<FieldT>::min());
    constexpr auto highest = static_cast<double>(std::numeric_limits<FieldT>::max());
    const double rounded = std::round(static_cast<double>(intensity));
    if (rounded <= lowest)
      return std::numeric_limits<FieldT>::min();
    // Not a cast, as the highest 64-bit integer is not a double.
    return rounded >= highest ? std::numeric_limits<FieldT>::max()
                              : static_cast<FieldT>(rounded);
  }
  else
    return static_cast<FieldT>(intensity);
}

} // namespace detail

/** \brief Sets the intensity field of a point, if its type has one. An integer field is
 * set to its nearest value. */
template <typename PointT>
void
setNativeIntensity([[maybe_unused]] PointT& point, [[maybe_unused]] float intensity)
{
  if constexpr (has_intensity_field<PointT>)
    point.intensity = detail::fieldValue<decltype(point.intensity)>(intensity);
}

namespace detail {

/** \brief Whether y follows x and z follows y, as far as they are registered. */
template <typename PointT>
constexpr bool
areConsecutive()
{
  if constexpr (pcl::traits::has_xyz<PointT>::value) {
    constexpr std::size_t x = pcl::traits::offset<PointT, pcl::fields::x>::value;
    return pcl::traits::offset<PointT, pcl::fields::y>::value == x + sizeof(float) &&
           pcl::traits::offset<PointT, pcl::fields::z>::value == x + 2 * sizeof(float);
  }
  return true;
}

/** \brief Offset of a point's colour, bytes. */
template <typename PointT>
constexpr std::size_t
colourOffset()
{
  if constexpr (pcl::traits::has_field<PointT, pcl::fields::rgba>::value)
    return pcl::traits::offset<PointT, pcl::fields::rgba>::value;
  else
    return pcl::traits::offset<PointT, pcl::fields::rgb>::value;
}

} // namespace detail

/** \brief The colour of a point, which its type has to have: alpha, red, green and blue
 * from bit 24, 16, 8 and 0 on, as PCL's field rgba. */
template <typename PointT>
std::uint32_t
packedColour(const PointT& point)
{
  std::uint32_t packed;
  std::memcpy(&packed,
              reinterpret_cast<const unsigned char*>(&point) +
                  detail::colourOffset<PointT>(),
              sizeof(packed));
  return packed;
}

/** \brief Sets the colour of a point, if its type has one.
 * \param[in] packed as packedColour() gives it
 */
template <typename PointT>
void
setPackedColour([[maybe_unused]] PointT& point, [[maybe_unused]] std::uint32_t packed)
{
  if constexpr (has_colour_field<PointT>)
    std::memcpy(reinterpret_cast<unsigned char*>(&point) +
                    detail::colourOffset<PointT>(),
                &packed,
                sizeof(packed));
}

/** \brief Sets the colour field of a point, if its type has one; opaque.
 * \param[in] colour channels of 0 to 255
 */
template <typename PointT>
void
setColour(PointT& point, const io::VoxelColour& colour)
{
  setPackedColour(point,
                  0xff000000u | std::uint32_t{colour.r} << 16 |
                      std::uint32_t{colour.g} << 8 | colour.b);
}

/** \brief Points for the voxelizer; their intensities are not part of it.
 * \param[in] points not null; must not change while the view is used
 * \param[in] count their number
 */
template <typename PointT>
io::PointView
pointViewOf(const PointT* points, std::size_t count)
{
  static_assert(
      std::is_same<decltype(PointT::x), float>::value &&
          sizeof(PointT) % sizeof(float) == 0,
      "the point type needs float x, y, z and a size of whole floats; copy the "
      "cloud into a type of PCL's with pcl::copyPointCloud");
  static_assert(
      detail::areConsecutive<PointT>(),
      "the point type needs x, y and z one after the other; copy the cloud into a "
      "type of PCL's with pcl::copyPointCloud");
  io::PointView view;
  view.count = count;
  view.coordinates = &points->x;
  view.coordinate_stride = sizeof(PointT);
  if constexpr (has_colour_field<PointT>) {
    view.colours =
        reinterpret_cast<const unsigned char*>(points) + detail::colourOffset<PointT>();
    view.colour_stride = sizeof(PointT);
  }
  return view;
}

/** \brief The same with the points' own intensities, which have to be floats. */
template <typename PointT>
io::PointView
pointViewWithIntensities(const PointT* points, std::size_t count)
{
  io::PointView view = pointViewOf(points, count);
  view.intensities = &points->intensity;
  view.intensity_stride = view.coordinate_stride;
  return view;
}

/** \brief The points of a cloud for the voxelizer; their intensities are not part of
 * it.
 * \param[in] cloud must not change while the view is used
 */
template <typename PointT>
io::PointView
pointViewOf(const pcl::PointCloud<PointT>& cloud)
{
  if (!cloud.empty())
    return pointViewOf(cloud.points.data(), cloud.size());
  io::PointView view;
  // An empty cloud's frame has colours as the stream's others have.
  if constexpr (has_colour_field<PointT>)
    view.colours = &cloud;
  return view;
}

/** \brief The same with the points' own intensities, which have to be floats. */
template <typename PointT>
io::PointView
pointViewWithIntensities(const pcl::PointCloud<PointT>& cloud)
{
  return cloud.empty() ? pointViewOf(cloud)
                       : pointViewWithIntensities(cloud.points.data(), cloud.size());
}

} // namespace pcl_ext::PCL_EXT_ABI
