// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/long_integers.h"

#include "clouds/file_text.h"
#include "clouds/made_fields.h"
#include "clouds/point_fields.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

namespace pcl_ext {
namespace clouds {

namespace {

using pcl::PCLPointCloud2;
using pcl::PCLPointField;

bool
isLong(const PCLPointField& field)
{
  const FileField type = fileFieldOf(field);
  return type.bytes == 8 && type.kind != FieldKind::Real && field.name != "_";
}

/** \brief Whether each value of a field of 64-bit integers is in a range. */
bool
areWithin(const PCLPointCloud2& cloud,
          const PCLPointField& field,
          std::int64_t least,
          std::int64_t most)
{
  const std::size_t points = std::size_t{cloud.width} * cloud.height;
  for (std::size_t i = 0; i < points; ++i)
    for (std::uint32_t j = 0; j < field.count; ++j) {
      std::int64_t number;
      std::memcpy(&number,
                  &cloud.data[i * cloud.point_step + field.offset + 8 * j],
                  sizeof(number));
      if (number > most || number < least)
        return false;
    }
  return true;
}

/** \brief A field of 64-bit integers as numbers that have its values. */
template <typename NumberT>
MadeField
asNumbers(PCLPointField field, std::uint8_t datatype)
{
  MadeField made;
  made.field = field;
  made.field.datatype = datatype;
  made.bytes = sizeof(NumberT) * field.count;
  made.make = [field = std::move(field)](const std::uint8_t* from, std::uint8_t* to) {
    PCLPointField value = field;
    for (std::uint32_t j = 0; j < field.count; ++j, value.offset += sizeof(double)) {
      const auto number = static_cast<NumberT>(NumberReader(value)(from));
      std::memcpy(to + sizeof(NumberT) * j, &number, sizeof(number));
    }
  };
  return made;
}

/** \brief A field of 64-bit integers as two numbers with the same bits. */
MadeField
asWords(const PCLPointField& field)
{
  MadeField made = copyOf(field);
  made.field.datatype = PCLPointField::UINT32;
  made.field.count *= 2;
  return made;
}

} // namespace

bool
LongIntegers::hasStep(const PCLPointField& field) const
{
  return std::find(with_step.begin(), with_step.end(), field.name) != with_step.end();
}

/** \brief True if a field may become numbers of a form, and these have all its values. */
bool
LongIntegers::holdsAll(Form form,
                       const PCLPointCloud2& cloud,
                       const PCLPointField& field) const
{
  constexpr std::int64_t one = 1;
  const bool is_signed = fileFieldOf(field).kind == FieldKind::Signed;
  switch (form) {
  case Form::Double:
    return (!one_of_several || hasStep(field)) &&
           areWithin(cloud, field, is_signed ? -(one << 53) : 0, one << 53);
  case Form::Int32:
    return one_of_several && is_signed &&
           areWithin(cloud, field, -(one << 31), (one << 31) - 1);
  case Form::Uint32:
    return one_of_several && areWithin(cloud, field, 0, (one << 32) - 1);
  case Form::TwoUint32:
    break;
  }
  return true;
}

LongIntegers::Form
LongIntegers::formOf(const PCLPointCloud2& cloud, const PCLPointField& field)
{
  const auto before = forms_.find(field.name);
  Form form = before == forms_.end() ? Form::Double : before->second;
  while (!holdsAll(form, cloud, field))
    form = static_cast<Form>(static_cast<int>(form) + 1);
  if (form != Form::Double && hasStep(field))
    throw FieldRefusal("the field '" + shownText(field.name) + "' (" +
                       typeName(fileFieldOf(field)) +
                       ") has values of more than 53 bits: 64-bit integers are kept "
                       "exactly, without a step: leave the step out");
  forms_[field.name] = form;
  return form;
}

void
LongIntegers::makeShorter(PCLPointCloud2& cloud, std::vector<std::string>& remarks)
{
  if (std::none_of(cloud.fields.begin(), cloud.fields.end(), isLong))
    return;
  std::vector<MadeField> fields;
  for (const PCLPointField& field : cloud.fields) {
    if (!isLong(field)) {
      fields.push_back(copyOf(field));
      continue;
    }
    const Form form = formOf(cloud, field);
    fields.push_back(
        form == Form::Double   ? asNumbers<double>(field, PCLPointField::FLOAT64)
        : form == Form::Int32  ? asNumbers<std::int32_t>(field, PCLPointField::INT32)
        : form == Form::Uint32 ? asNumbers<std::uint32_t>(field, PCLPointField::UINT32)
                               : asWords(field));
    remarks.push_back("its field " + shownText(field.name) + " (" +
                      typeName(fileFieldOf(field)) + ") is taken as " +
                      (form != Form::TwoUint32
                           ? typeName(fileFieldOf(fields.back().field)) +
                                 ", which has the same values"
                           : std::string("two uint32 with the same bits, as ") +
                                 (one_of_several ? "uint32" : "float64") +
                                 " has not all of its values"));
  }
  setFields(fields, cloud);
}

} // namespace clouds
} // namespace pcl_ext
