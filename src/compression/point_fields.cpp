// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/impl/point_fields.h>

#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace detail {

namespace {

/** \brief Whether frames have fields of its datatype; not of bool or 64-bit integers. */
bool
hasFieldType(const pcl::PCLPointField& field)
{
  return field.datatype >= pcl::PCLPointField::INT8 &&
         field.datatype <= pcl::PCLPointField::FLOAT64;
}

/** \brief Whether a field is a packed colour: the same 32 bits, whatever their type. */
bool
isColour(const std::string& name, FieldType type)
{
  return (name == "rgb" || name == "rgba") && sizeOf(type) == sizeof(std::uint32_t);
}

} // namespace

void
PointFields::add(const char* name,
                 std::size_t offset,
                 std::uint8_t datatype,
                 std::uint32_t count)
{
  pcl::PCLPointField field;
  field.name = name;
  field.offset = static_cast<pcl::uindex_t>(offset);
  field.datatype = datatype;
  field.count = count;
  if (field.name != "x" && field.name != "y" && field.name != "z")
    fields_.push_back(field);
}

std::vector<FieldView>
PointFields::viewsOf(const void* points, std::size_t stride) const
{
  std::vector<FieldView> views;
  for (const pcl::PCLPointField& field : fields_) {
    FieldView& view = views.emplace_back();
    view.description.name = field.name;
    view.description.type = static_cast<FieldType>(field.datatype);
    view.description.count = field.count;
    view.first = static_cast<const unsigned char*>(points) + field.offset;
    view.stride = stride;
  }
  return views;
}

void
PointFields::set(const VoxelFrame& frame, void* points, std::size_t stride) const
{
  for (const FrameField& field : frame.fields)
    for (const pcl::PCLPointField& target : fields_) {
      const auto own_type = static_cast<FieldType>(target.datatype);
      const bool are_colours =
          isColour(target.name, own_type) && isColour(field.name, field.type);
      if ((target.name != field.name && !are_colours) || !hasFieldType(target))
        continue;
      // Of colours the bits are copied. A frame may have any type under any name.
      const FieldType type = are_colours ? field.type : own_type;
      auto* const first = static_cast<unsigned char*>(points) + target.offset;
      const std::size_t count = frame.pointCount();
      for (std::size_t i = 0; i < count; ++i)
        for (std::size_t k = 0; k < field.count && k < target.count; ++k) {
          const std::uint64_t number = field.numbers[i * field.count + k];
          unsigned char* const value =
              first + frame.cloudIndex(i) * stride + k * sizeOf(type);
          if (type == field.type)
            fieldValue(field, number, value);
          else
            storeFieldValue(type, fieldValue(field, number), value);
        }
    }
}

} // namespace detail
} // namespace pcl_ext::PCL_EXT_ABI::io
