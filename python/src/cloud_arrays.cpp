// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "cloud_arrays.h"

#include <pybind11/stl.h>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>

namespace pcl_ext::python {

namespace {

std::string
textOf(const py::handle& object)
{
  return py::str(object).cast<std::string>();
}

/** \brief An array-like argument as an array. */
py::array
arrayOf(const py::object& object, const std::string& name)
{
  if (py::hasattr(object, "mask") && py::hasattr(object, "filled"))
    throw py::type_error(name + " is a masked array; pass " + name +
                         ".filled(value); points whose x, y or z is NaN are left out");
  py::array array = py::array::ensure(object);
  if (!array)
    throw py::type_error(name + " is a '" +
                         textOf(py::type::of(object).attr("__name__")) +
                         "', of which numpy makes no array");
  const char kind = array.dtype().kind();
  if (kind == 'O' || kind == 'U' || kind == 'S')
    throw py::type_error(name + " is no array of numbers; numpy makes dtype " +
                         textOf(array.dtype()) + " of it");
  return array;
}

std::optional<NumberType>
numberType(const py::dtype& type)
{
  const auto choose = [&](std::initializer_list<NumberType> types) {
    // By the logarithm of the size.
    const auto size = type.itemsize();
    const std::size_t index = size == 1 ? 0 : size == 2 ? 1 : size == 4 ? 2 : 3;
    return types.begin()[index];
  };
  if (type.kind() == 'f' && type.itemsize() == 4)
    return NumberType::Float32;
  if (type.kind() == 'f' && type.itemsize() == 8)
    return NumberType::Float64;
  if (type.kind() == 'i')
    return choose(
        {NumberType::Int8, NumberType::Int16, NumberType::Int32, NumberType::Int64});
  if (type.kind() == 'u')
    return choose({NumberType::UInt8,
                   NumberType::UInt16,
                   NumberType::UInt32,
                   NumberType::UInt64});
  return std::nullopt;
}

bool
isNative(const py::dtype& type)
{
  return type.attr("isnative").cast<bool>();
}

/** \brief The type of the values of a field, if it can be kept. */
std::optional<io::FieldType>
fieldType(const py::dtype& type)
{
  if (!isNative(type))
    return std::nullopt;
  return valueNamed(io::field_types, textOf(type.attr("name")));
}

/** \brief Numbers in types and byte orders that a column does not have become float32,
 * or float64 if they have more bytes. */
py::array
inKnownType(const py::array& numbers)
{
  if (isNative(numbers.dtype()) && numberType(numbers.dtype()))
    return numbers;
  const char* const type = numbers.dtype().itemsize() > 4 ? "float64" : "float32";
  return numbers.attr("astype")(type).cast<py::array>();
}

using Shape = std::vector<py::ssize_t>;

/** \brief The shape of an array without its last dimensions. */
Shape
shapeOf(const py::array& array, py::ssize_t left_out = 0)
{
  return {array.shape(), array.shape() + array.ndim() - left_out};
}

[[noreturn]] void
throwShape(const std::string& name, const py::array& array, const std::string& demand)
{
  throw py::value_error(name + " has shape " + textOf(array.attr("shape")) + "; " +
                        demand);
}

std::string
demandOfShape(const Shape& shape, const std::string& demand)
{
  return "the cloud has shape " + textOf(py::tuple(py::cast(shape))) +
         ", and each point needs " + demand;
}

void
checkFloat(const std::string& name, const py::dtype& type)
{
  if (type.kind() != 'f')
    throw py::type_error(name + " has dtype " + textOf(type) +
                         "; it must be float32 or float64, in metres");
}

bool
hasField(const py::array& array, const char* name)
{
  return array.dtype().attr("names").contains(name);
}

/** \brief A field of a structured array of one dimension. */
py::array
field(const py::array& points, const char* name)
{
  const auto numbers = points.attr("__getitem__")(name).cast<py::array>();
  if (numbers.ndim() != 1)
    throw py::value_error("the field " + std::string(name) +
                          " of xyz has several numbers for each point");
  return numbers;
}

} // namespace

CloudArrays::CloudArrays(const py::object& xyz,
                         const py::object& intensity,
                         const py::object& colour)
{
  const py::array points = arrayOf(xyz, "xyz");
  if (points.dtype().has_fields())
    takeFields(points);
  else
    takeCoordinates(points);
  if (!intensity.is_none())
    takeIntensity(intensity);
  if (!colour.is_none())
    takeColour(colour);
}

Column
CloudArrays::columnOf(const py::array& numbers)
{
  arrays_.push_back(inKnownType(numbers));
  const py::array& array = arrays_.back();
  return {static_cast<const char*>(array.data()),
          array.strides(0),
          *numberType(array.dtype())};
}

/** \brief Takes an array of rows and columns for an image. */
void
CloudArrays::setImage()
{
  constexpr py::ssize_t most = std::numeric_limits<std::uint32_t>::max();
  if (shape_.size() == 2 && shape_[0] <= most && shape_[1] <= most)
    columns_.image = {static_cast<std::uint32_t>(shape_[1]),
                      static_cast<std::uint32_t>(shape_[0])};
}

void
CloudArrays::takeFields(const py::array& points)
{
  if (points.ndim() == 0)
    throwShape("xyz", points, "one record is no array of points");
  if (points.ndim() > 2)
    throwShape("xyz", points, "a structured array must be (N,) or (rows, columns)");
  for (const char* name : {"x", "y", "z"})
    if (!hasField(points, name))
      throw py::value_error("xyz has fields " + textOf(points.dtype().attr("names")) +
                            "; it must have x, y and z");
  shape_ = shapeOf(points);
  setImage();
  const auto row = points.attr("reshape")(-1).cast<py::array>();
  columns_.count = static_cast<std::size_t>(row.size());
  std::size_t axis = 0;
  for (const char* name : {"x", "y", "z"}) {
    const py::array numbers = field(row, name);
    checkFloat("the field " + std::string(name) + " of xyz", numbers.dtype());
    columns_.coordinates[axis++] = columnOf(numbers);
  }
  if (hasField(row, "intensity"))
    takeIntensity(points.attr("__getitem__")("intensity"));
  has_intensity_argument_ = false;
  takeColourFields(row);
  takeFurtherFields(row);
}

void
CloudArrays::takeColourFields(const py::array& points)
{
  for (const char* name : {"rgb", "rgba"})
    if (hasField(points, name)) {
      const py::array packed = field(points, name);
      if (packed.dtype().itemsize() != 4 || !isNative(packed.dtype()))
        throw py::type_error("the field " + std::string(name) + " of xyz has dtype " +
                             textOf(packed.dtype()) +
                             "; it must have the 32 bits of PCL's colour, float32 or "
                             "uint32 in the machine's byte order");
      arrays_.push_back(packed);
      columns_.packed_colour = {static_cast<const char*>(packed.data()),
                                packed.strides(0),
                                NumberType::UInt32};
      return;
    }
  if (!hasField(points, "r") || !hasField(points, "g") || !hasField(points, "b"))
    return;
  columns_.channels.emplace();
  std::size_t channel = 0;
  for (const char* name : {"r", "g", "b"}) {
    const py::array numbers = field(points, name);
    if (numbers.dtype().kind() != 'u' || numbers.dtype().itemsize() != 1)
      throw py::type_error("the field " + std::string(name) + " of xyz has dtype " +
                           textOf(numbers.dtype()) + "; it must be uint8");
    (*columns_.channels)[channel++] = columnOf(numbers);
  }
}

void
CloudArrays::takeFurtherFields(const py::array& points)
{
  arrays_.push_back(points);
  const py::object types = points.dtype().attr("fields");
  for (const py::handle& name : points.dtype().attr("names")) {
    FieldColumn field;
    // A name that has no UTF-8 has a replacement.
    field.description.name =
        name.attr("encode")("utf-8", "replace").cast<py::bytes>().cast<std::string>();
    const std::string& text = field.description.name;
    const py::object place = types[name];
    const auto type = place[py::int_(0)].cast<py::dtype>();
    const auto value_type = type.attr("base").cast<py::dtype>();
    const auto known_type = fieldType(value_type);
    if (text == "x" || text == "y" || text == "z" || type.itemsize() == 0)
      continue;
    if (!known_type) {
      columns_.unknown_fields.push_back({text, textOf(value_type)});
      continue;
    }
    field.description.type = *known_type;
    field.description.count =
        static_cast<std::uint32_t>(type.itemsize() / value_type.itemsize());
    field.first = static_cast<const char*>(points.data()) +
                  place[py::int_(1)].cast<std::ptrdiff_t>();
    field.stride = points.strides(0);
    field.is_channel = columns_.channels && (text == "r" || text == "g" || text == "b");
    columns_.fields.push_back(field);
  }
}

void
CloudArrays::takeCoordinates(py::array points)
{
  if (points.ndim() < 2 || points.ndim() > 3 || points.shape(points.ndim() - 1) != 3)
    throwShape("xyz",
               points,
               "it must be (N, 3) or (rows, columns, 3); of more columns pass "
               "xyz[:, :3]");
  checkFloat("xyz", points.dtype());
  shape_ = shapeOf(points, 1);
  setImage();
  points = inKnownType(points);
  if (points.ndim() > 2)
    points = points.attr("reshape")(-1, 3).cast<py::array>();
  arrays_.push_back(points);
  columns_.count = static_cast<std::size_t>(points.shape(0));
  for (std::size_t axis = 0; axis < 3; ++axis)
    columns_.coordinates[axis] = {static_cast<const char*>(points.data()) +
                                      static_cast<std::ptrdiff_t>(axis) *
                                          points.strides(1),
                                  points.strides(0),
                                  *numberType(points.dtype())};
}

void
CloudArrays::takeIntensity(const py::object& intensity)
{
  py::array numbers = arrayOf(intensity, "intensity");
  const char kind = numbers.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u')
    throw py::type_error("intensity has dtype " + textOf(numbers.dtype()) +
                         "; it must be floating-point numbers or integers");
  if (shapeOf(numbers) != shape_)
    throwShape("intensity", numbers, demandOfShape(shape_, "one"));
  if (numbers.ndim() != 1)
    numbers = numbers.attr("reshape")(-1).cast<py::array>();
  columns_.intensity = columnOf(numbers);
  has_intensity_argument_ = true;
}

void
CloudArrays::takeColour(const py::object& colour)
{
  py::array numbers = arrayOf(colour, "colour");
  if (numbers.dtype().kind() != 'u' || numbers.dtype().itemsize() != 1)
    throw py::type_error("colour has dtype " + textOf(numbers.dtype()) +
                         "; it must be uint8, 0 to 255");
  const auto channels = numbers.ndim() == 0 ? 0 : numbers.shape(numbers.ndim() - 1);
  if ((channels != 3 && channels != 4) || shapeOf(numbers, 1) != shape_)
    throwShape("colour", numbers, demandOfShape(shape_, "red, green and blue"));
  numbers = numbers.attr("reshape")(columns_.count, channels).cast<py::array>();
  arrays_.push_back(numbers);
  columns_.packed_colour.reset();
  columns_.channels.emplace();
  for (std::size_t channel = 0; channel < 3; ++channel)
    (*columns_.channels)[channel] = {static_cast<const char*>(numbers.data()) +
                                         static_cast<std::ptrdiff_t>(channel) *
                                             numbers.strides(1),
                                     numbers.strides(0),
                                     NumberType::UInt8};
}

} // namespace pcl_ext::python
