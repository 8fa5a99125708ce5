// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_frame.h>

#include <pcl/for_each_type.h>
#include <pcl/PCLPointField.h>
#include <pcl/point_cloud.h>
#include <pcl/type_traits.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext {
namespace io {
namespace detail {

/** \brief Adds the registered fields of a point type but x, y and z to a list. */
template <typename PointT>
struct FurtherFields {
  std::vector<pcl::PCLPointField>& fields;

  template <typename TagT>
  void
  operator()()
  {
    pcl::PCLPointField field;
    field.name = pcl::traits::name<PointT, TagT>::value;
    field.offset = pcl::traits::offset<PointT, TagT>::value;
    field.datatype = pcl::traits::datatype<PointT, TagT>::value;
    field.count = pcl::traits::datatype<PointT, TagT>::size;
    if (field.name != "x" && field.name != "y" && field.name != "z" &&
        field.datatype >= pcl::PCLPointField::INT8 &&
        field.datatype <= pcl::PCLPointField::FLOAT64)
      fields.push_back(field);
  }
};

/** \brief The registered fields of a point type but x, y and z, with their offsets. */
template <typename PointT>
std::vector<pcl::PCLPointField>
furtherFields()
{
  std::vector<pcl::PCLPointField> further;
  pcl::for_each_type<typename pcl::traits::fieldList<PointT>::type>(
      FurtherFields<PointT>{further});
  return further;
}

/** \brief Views of these fields of a cloud. */
template <typename PointT>
std::vector<FieldView>
fieldViewsOf(const pcl::PointCloud<PointT>& cloud)
{
  std::vector<FieldView> views;
  for (const pcl::PCLPointField& field : furtherFields<PointT>()) {
    FieldView& view = views.emplace_back();
    view.description.name = field.name;
    view.description.type = static_cast<FieldType>(field.datatype);
    view.description.count = field.count;
    view.first =
        reinterpret_cast<const unsigned char*>(cloud.points.data()) + field.offset;
    view.stride = sizeof(PointT);
  }
  return views;
}

/** \brief Sets the fields of points that a frame has, by name; values of other datatypes
 * are converted.
 * \param[in,out] cloud with the points of the frame
 */
template <typename PointT>
void
setFields(const VoxelFrame& frame, pcl::PointCloud<PointT>& cloud)
{
  // Before the list of the type's fields, which takes memory.
  if (frame.fields.empty())
    return;
  const std::vector<pcl::PCLPointField> targets = furtherFields<PointT>();
  for (const FrameField& field : frame.fields)
    for (const pcl::PCLPointField& target : targets) {
      if (target.name != field.name)
        continue;
      const auto type = static_cast<FieldType>(target.datatype);
      auto* const first = reinterpret_cast<unsigned char*>(cloud.points.data());
      const std::size_t points = frame.pointCount();
      for (std::size_t i = 0; i < points; ++i)
        for (std::size_t k = 0; k < field.count && k < target.count; ++k) {
          const std::uint64_t number = field.numbers[i * field.count + k];
          unsigned char* const value = first + frame.cloudIndex(i) * sizeof(PointT) +
                                       target.offset + k * sizeOf(type);
          if (type == field.type)
            fieldValue(field, number, value);
          else
            storeFieldValue(type, fieldValue(field, number), value);
        }
    }
}

} // namespace detail
} // namespace io
} // namespace pcl_ext
