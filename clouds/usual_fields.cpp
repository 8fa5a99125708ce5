// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/usual_fields.h"

#include <pcl_ext/filters/sensor_preprocessor.h>

#include "clouds/file_text.h"
#include "clouds/made_fields.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace pcl_ext {
namespace clouds {

namespace {

using pcl::PCLPointCloud2;
using pcl::PCLPointField;

/** \brief Says which names several fields have. */
void
tellNamesOfSeveral(const PCLPointCloud2& cloud, std::vector<std::string>& remarks)
{
  for (auto field = cloud.fields.begin(); field != cloud.fields.end(); ++field)
    if (field->name != "_" &&
        std::count_if(cloud.fields.begin(), field, [&field](const auto& other) {
          return other.name == field->name;
        }) == 1)
      remarks.push_back("several of its fields are named '" + shownText(field->name) +
                        "'; files have '" + shownText(field->name) +
                        "_' for the second");
}

/** \brief Turns coordinates into floats or doubles, all of one type. */
void
makeCoordinatesReal(PCLPointCloud2& cloud, std::vector<std::string>& remarks)
{
  CoordinateTypes types{};
  for (std::size_t axis = 0; axis < types.size(); ++axis) {
    const PCLPointField* const field =
        findField(cloud, std::string(1, static_cast<char>('x' + axis)));
    if (field == nullptr)
      return;
    types[axis] = field->datatype;
  }
  if (areReal(types))
    return;
  const bool is_double = needDoubles(types);
  std::vector<MadeField> fields;
  for (const PCLPointField& field : cloud.fields) {
    if (!isCoordinateName(field.name) || lowerCase(field.name) != field.name ||
        field.count != 1) {
      fields.push_back(copyOf(field));
      continue;
    }
    MadeField& made = fields.emplace_back();
    made.field = field;
    made.field.datatype = is_double ? PCLPointField::FLOAT64 : PCLPointField::FLOAT32;
    made.bytes = is_double ? sizeof(double) : sizeof(float);
    made.make = [read = NumberReader(field), is_double](const auto* from, auto* to) {
      const double number = read(from);
      const auto less_precise = static_cast<float>(number);
      if (is_double)
        std::memcpy(to, &number, sizeof(number));
      else
        std::memcpy(to, &less_precise, sizeof(less_precise));
    };
  }
  setFields(fields, cloud);
  remarks.push_back("its " + describeCoordinates(types));
}

/** \brief The bits of packed colours are those of an unsigned number, which PCL takes
 * for them. */
void
makePackedColourUnsigned(PCLPointCloud2& cloud)
{
  for (PCLPointField& field : cloud.fields)
    if ((field.name == "rgb" || field.name == "rgba") &&
        field.datatype == PCLPointField::INT32)
      field.datatype = PCLPointField::UINT32;
}

} // namespace

void
nameUsually(PCLPointCloud2& cloud, std::vector<std::string>& remarks)
{
  std::string given;
  std::string usual;
  for (PCLPointField& field : cloud.fields) {
    const std::string small = lowerCase(field.name);
    const bool is_known =
        isCoordinateName(field.name) || small == "rgb" || small == "rgba";
    if (!is_known || small == field.name || findField(cloud, small) != nullptr)
      continue;
    given += (given.empty() ? "" : ", ") + field.name;
    usual += (usual.empty() ? "" : ", ") + small;
    field.name = small;
  }
  if (!given.empty())
    remarks.push_back("its fields " + given + " are taken as " + usual);
}

std::vector<std::string>
UsualFields::giveTo(PCLPointCloud2& cloud, bool is_ply)
{
  std::vector<std::string> remarks;
  nameUsually(cloud, remarks);
  tellNamesOfSeveral(cloud, remarks);
  makeCoordinatesReal(cloud, remarks);
  makePackedColourUnsigned(cloud);
  if (const std::string clamped = packColours(cloud, is_ply, colours_, remarks);
      !clamped.empty())
    remarks.push_back(clamped);
  long_integers_.makeShorter(cloud, remarks);
  return remarks;
}

} // namespace clouds
} // namespace pcl_ext
