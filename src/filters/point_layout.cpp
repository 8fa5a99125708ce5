// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/sensor_preprocessor.h>

#include <boost/predef/other/endian.h>

#include <algorithm>
#include <array>

namespace pcl_ext::PCL_EXT_ABI {

namespace {

PreprocessingStatus
invalidLayout(const std::string& what)
{
  return {PreprocessingCode::InvalidLayout, "invalid layout: " + what};
}

const pcl::PCLPointField*
findField(const pcl::PCLPointCloud2& cloud, const std::string& name)
{
  const auto field =
      std::find_if(cloud.fields.begin(),
                   cloud.fields.end(),
                   [&](const auto& candidate) { return candidate.name == name; });
  return field != cloud.fields.end() ? &*field : nullptr;
}

/** \brief Size of a datatype in bytes; 0 if it is unknown. */
std::uint64_t
sizeOf(std::uint8_t datatype)
{
  switch (datatype) {
  case detail::bool_datatype:
    return sizeof(std::uint8_t);
  case detail::int64_datatype:
  case detail::uint64_datatype:
    return sizeof(std::uint64_t);
  default:
    return datatype >= pcl::PCLPointField::INT8 &&
                   datatype <= pcl::PCLPointField::FLOAT64
               ? io::sizeOf(static_cast<io::FieldType>(datatype))
               : 0;
  }
}

/** \brief Checks that a field is one readable number within each point. */
PreprocessingStatus
checkField(const pcl::PCLPointCloud2& cloud, const pcl::PCLPointField& field)
{
  const std::uint64_t size = sizeOf(field.datatype);
  if (size == 0)
    return {PreprocessingCode::InvalidField,
            "field '" + field.name + "' has the unknown datatype " +
                std::to_string(field.datatype)};
  // Some programs write a count of 0 for a single number.
  if (field.count > 1)
    return {PreprocessingCode::InvalidField,
            "field '" + field.name + "' holds " + std::to_string(field.count) +
                " numbers; it must hold one"};
  if (field.offset + size > cloud.point_step)
    return {PreprocessingCode::InvalidField,
            "field '" + field.name + "' ends at byte " +
                std::to_string(field.offset + size) + " of a point of " +
                std::to_string(cloud.point_step)};
  return {};
}

/** \brief Checks that all points are within the data; in 64 bits, so that nothing
 * overflows.
 */
PreprocessingStatus
checkSteps(const pcl::PCLPointCloud2& cloud)
{
  const std::uint64_t width = cloud.width;
  const std::uint64_t height = cloud.height;
  // One of both was forgotten. Who sends both as 0 may reuse the memory of a larger cloud.
  if ((width == 0) != (height == 0) && cloud.point_step > 0 &&
      cloud.data.size() >= cloud.point_step)
    return invalidLayout(std::to_string(cloud.data.size()) +
                         " bytes of points, but a width of " + std::to_string(width) +
                         " and a height of " + std::to_string(height));
  if (width == 0 || height == 0)
    return {};
  if (cloud.point_step == 0)
    return invalidLayout("point_step is 0");
  if (cloud.is_bigendian != static_cast<std::uint8_t>(BOOST_ENDIAN_BIG_BYTE))
    return invalidLayout("the byte order is not that of this machine");
  const std::uint64_t last_row = width * cloud.point_step;
  const std::uint64_t row_step = rowStep(cloud);
  if (last_row > row_step)
    return invalidLayout(
        std::to_string(width) + " points of " + std::to_string(cloud.point_step) +
        " bytes do not fit rows of " + std::to_string(row_step) + " bytes");
  // The last row may end with its last point. Division, as the product may overflow.
  if (cloud.data.size() < last_row ||
      (cloud.data.size() - last_row) / row_step < height - 1)
    return invalidLayout(std::to_string(height) + " rows of " +
                         std::to_string(cloud.row_step) + " bytes are not within " +
                         std::to_string(cloud.data.size()) + " bytes");
  return {};
}

/** \brief The first colour that can be read; clouds are not refused for their
 * colours. */
void
findColour(const pcl::PCLPointCloud2& cloud, PointLayout& layout)
{
  for (const char* const name : {"rgb", "rgba"}) {
    const pcl::PCLPointField* const field = findField(cloud, name);
    if (field == nullptr || !checkField(cloud, *field).ok() ||
        (field->datatype != pcl::PCLPointField::FLOAT32 &&
         field->datatype != pcl::PCLPointField::UINT32 &&
         field->datatype != pcl::PCLPointField::INT32))
      continue;
    layout.has_colour = true;
    layout.colour = field->offset;
    return;
  }
}

/** \brief A datatype as users name it: "uint16". */
std::string
typeName(std::uint8_t datatype)
{
  constexpr std::array<const char*, 11> names = {"",
                                                 "int8",
                                                 "uint8",
                                                 "int16",
                                                 "uint16",
                                                 "int32",
                                                 "uint32",
                                                 "float32",
                                                 "float64",
                                                 "int64",
                                                 "uint64"};
  return datatype < names.size() ? names[datatype] : std::to_string(datatype);
}

} // namespace

bool
areReal(const CoordinateTypes& types)
{
  return (types[0] == pcl::PCLPointField::FLOAT32 ||
          types[0] == pcl::PCLPointField::FLOAT64) &&
         types[1] == types[0] && types[2] == types[0];
}

bool
needDoubles(const CoordinateTypes& types)
{
  return std::any_of(types.begin(), types.end(), [](std::uint8_t type) {
    return type != pcl::PCLPointField::FLOAT32 && sizeOf(type) > 2;
  });
}

std::string
describeCoordinates(const CoordinateTypes& types)
{
  return areReal(types)
             ? std::string()
             : "coordinates x, y and z (" + typeName(types[0]) + ", " +
                   typeName(types[1]) + ", " + typeName(types[2]) + ") are taken as " +
                   (needDoubles(types) ? "float64" : "float32") + ", metres";
}

std::size_t
rowStep(const pcl::PCLPointCloud2& cloud)
{
  const std::uint64_t packed = std::uint64_t{cloud.width} * cloud.point_step;
  if (packed == 0)
    return cloud.row_step;
  // Division, as the product may overflow.
  const bool is_whole =
      cloud.data.size() % packed == 0 && cloud.data.size() / packed == cloud.height;
  // More may follow one row, whose step tells nothing.
  const bool is_one_row =
      cloud.height == 1 && cloud.row_step < packed && cloud.data.size() >= packed;
  return is_whole || is_one_row ? static_cast<std::size_t>(packed) : cloud.row_step;
}

bool
hasReadableField(const pcl::PCLPointCloud2& cloud, const std::string& name)
{
  const pcl::PCLPointField* const field = findField(cloud, name);
  return field != nullptr && checkField(cloud, *field).ok();
}

PreprocessingStatus
findPointLayout(const pcl::PCLPointCloud2& cloud,
                const std::string& intensity_field,
                bool needs_intensity,
                bool reads_colour,
                PointLayout& layout)
{
  layout = PointLayout();
  if (PreprocessingStatus status = checkSteps(cloud); !status.ok())
    return status;
  const char* const names[] = {"x", "y", "z"};
  std::uint32_t* const offsets[] = {&layout.x, &layout.y, &layout.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const pcl::PCLPointField* field = findField(cloud, names[axis]);
    if (field == nullptr)
      return {PreprocessingCode::MissingField,
              std::string("the cloud has no field '") + names[axis] + "'"};
    if (PreprocessingStatus status = checkField(cloud, *field); !status.ok())
      return status;
    if (field->datatype == detail::bool_datatype)
      return {PreprocessingCode::InvalidField,
              std::string("field '") + names[axis] +
                  "' must be a number, but its datatype is " +
                  std::to_string(field->datatype)};
    *offsets[axis] = field->offset;
    layout.types[axis] = field->datatype;
  }
  layout.is_double = needDoubles(layout.types);
  if (reads_colour)
    findColour(cloud, layout);

  // Models that do not use the intensity accept a field that cannot be read.
  if (!needs_intensity)
    return {};
  const pcl::PCLPointField* field = findField(cloud, intensity_field);
  if (field == nullptr)
    return {PreprocessingCode::MissingField,
            "the intensity model is native, but the cloud has no field '" +
                intensity_field + "'"};
  if (PreprocessingStatus status = checkField(cloud, *field); !status.ok())
    return status;
  layout.has_intensity = true;
  layout.intensity = field->offset;
  layout.intensity_datatype = field->datatype;
  return {};
}

std::vector<FoundField>
findFields(const pcl::PCLPointCloud2& cloud)
{
  std::vector<FoundField> found;
  for (const pcl::PCLPointField& field : cloud.fields) {
    if (field.name == "x" || field.name == "y" || field.name == "z" ||
        field.name == "_" || field.datatype < pcl::PCLPointField::INT8 ||
        field.datatype > pcl::PCLPointField::FLOAT64)
      continue;
    // Some programs write a count of 0 for a single number.
    const std::uint64_t count = std::max<std::uint64_t>(field.count, 1);
    if (field.offset + count * sizeOf(field.datatype) > cloud.point_step)
      continue;
    FoundField& added = found.emplace_back();
    added.offset = field.offset;
    added.description.name = field.name;
    added.description.type = static_cast<io::FieldType>(field.datatype);
    added.description.count = static_cast<std::uint32_t>(count);
  }
  return found;
}

} // namespace pcl_ext::PCL_EXT_ABI
