// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Headers of PLY files.
 */
#pragma once

#include "clouds/file_text.h"

#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief A number of each element, or a list of numbers. */
struct PlyProperty {
  FileField field;                ///< of a list: its numbers
  std::optional<FileField> count; ///< of a list: how many follow
};

/** \brief What a file has some of, such as vertices. */
struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  bool has_unknown = false; ///< properties that PLY has not, which are not among them
};

/** \brief What comes before the elements. */
struct PlyHeader {
  bool has_format = false;
  bool is_text = false;
  bool is_big_endian = false;
  std::vector<PlyElement> elements;
  std::uint64_t columns = 0; ///< of an image, as a remark tells; 0: there are none
  std::uint64_t rows = 0;
  std::uint64_t bytes = 0; ///< of the header
  std::uint64_t lines = 0; ///< of the header
  char line_end = '\n';    ///< see lineEndOf()
  bool has_end = false;
};

/** \brief Whether elements have lists. */
bool
hasList(const PlyElement& element);

/** \brief The name that PCL gives the field of a property: normals have other ones. */
std::string
plyNameToField(const std::string& property);

/** \brief The name of a field's property. */
std::string
fieldNameToPly(const std::string& field);

/** \brief Reads a header.
 * \throws std::runtime_error with what is wrong
 */
PlyHeader
readPlyHeader(std::istream& file);

} // namespace clouds
} // namespace pcl_ext
