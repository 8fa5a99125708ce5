// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_field.h>
#include <pcl_ext/compression/point_view.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::python {

/** \brief Types of numbers that a column may have, in the machine's byte order. */
enum class NumberType {
  Float32,
  Float64,
  Int8,
  Int16,
  Int32,
  Int64,
  UInt8,
  UInt16,
  UInt32,
  UInt64
};

/** \brief One number for each point: a column of an array or a field of a structured
 * one. */
struct Column {
  const char* first = nullptr; ///< may be unaligned
  std::ptrdiff_t stride = 0;   ///< bytes from one number to the next; any sign
  NumberType type = NumberType::Float32;
};

/** \brief A further field of a structured array. The values of a point lie side by
 * side. */
struct FieldColumn {
  io::FieldDescription description; ///< without a step
  const char* first = nullptr;      ///< may be unaligned
  std::ptrdiff_t stride = 0;        ///< bytes from one point to the next; any sign
  bool is_channel = false;          ///< red, green or blue of the array's colour
};

/** \brief A further field whose values have a type that cannot be kept. */
struct UnknownField {
  std::string name;
  std::string type; ///< in numpy's words
};

/** \brief A cloud as it lies in the caller's arrays. */
struct CloudColumns {
  std::size_t count = 0;
  io::ImageSize image;               ///< of an array of rows and columns
  std::array<Column, 3> coordinates; ///< Float32 or Float64, metres
  std::optional<Column> intensity;
  std::optional<Column> packed_colour;           ///< 32 bits, as PCL's field rgba
  std::optional<std::array<Column, 3>> channels; ///< or red, green and blue, UInt8
  std::vector<FieldColumn> fields;               ///< all but x, y and z
  std::vector<UnknownField> unknown_fields;      ///< that are not among these

  bool
  hasColours() const
  {
    return packed_colour || channels;
  }
};

/** \brief What the type of a field must be. */
std::string
fieldDemand();

/** \brief Copies of columns that a PointView cannot point to; reused from cloud to
 * cloud. */
struct CloudMemory {
  std::vector<float> coordinates;
  std::vector<double> double_coordinates;
  std::vector<float> intensities;
  std::vector<std::uint32_t> colours;
  std::vector<std::vector<char>> fields;
};

/** \brief The points for the voxelizer: where they lie if its strides allow that, else
 * copies.
 * \param[in] cloud must not change while the view is used
 * \param[in] uses_intensities the view has the intensities, which the cloud must have
 * \param[in] settings of the stream: the view has fields if some are kept; channels of a
 * colour that is coded only if they are named
 * \param[out] memory for copies; must not change while the view is used
 */
io::PointView
viewOf(const CloudColumns& cloud,
       bool uses_intensities,
       const io::StreamSettings& settings,
       CloudMemory& memory);

} // namespace pcl_ext::python
