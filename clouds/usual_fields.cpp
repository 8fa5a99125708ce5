// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/usual_fields.h"

#include <pcl_ext/filters/sensor_preprocessor.h>

#include "clouds/file_text.h"
#include "clouds/made_fields.h"
#include "clouds/point_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>

namespace pcl_ext {
namespace clouds {

namespace {

using Kind = FileField::Kind;
using pcl::PCLPointCloud2;
using pcl::PCLPointField;

/** \brief A number as users name it: "uint16". */
std::string
typeName(const FileField& field)
{
  const std::string bits = std::to_string(8 * field.bytes);
  return (field.kind == Kind::Real     ? "float"
          : field.kind == Kind::Signed ? "int"
                                       : "uint") +
         bits;
}

const PCLPointField*
find(const PCLPointCloud2& cloud, const std::string& name)
{
  const auto found = std::find_if(
      cloud.fields.begin(), cloud.fields.end(), [&name](const auto& field) {
        return field.name == name && field.count == 1;
      });
  return found == cloud.fields.end() ? nullptr : &*found;
}

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
        find(cloud, std::string(1, static_cast<char>('x' + axis)));
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

/** \brief A field of 64-bit integers as one that frames have, see LongIntegers. */
MadeField
asShorter(const PCLPointCloud2& cloud,
          const PCLPointField& field,
          const LongIntegers& long_integers)
{
  const bool is_signed = fileFieldOf(field).kind == Kind::Signed;
  const auto& with_step = long_integers.with_step;
  const bool has_step =
      std::find(with_step.begin(), with_step.end(), field.name) != with_step.end();
  constexpr std::int64_t one = 1;
  if ((!long_integers.one_of_several || has_step) &&
      areWithin(cloud, field, is_signed ? -(one << 53) : 0, one << 53))
    return asNumbers<double>(field, PCLPointField::FLOAT64);
  if (has_step)
    throw FieldRefusal("the field '" + shownText(field.name) + "' (" +
                       typeName(fileFieldOf(field)) +
                       ") has values of more than 53 bits: 64-bit integers are kept "
                       "exactly, without a step: leave the step out");
  if (long_integers.one_of_several && is_signed &&
      areWithin(cloud, field, -(one << 31), (one << 31) - 1))
    return asNumbers<std::int32_t>(field, PCLPointField::INT32);
  if (long_integers.one_of_several && areWithin(cloud, field, 0, (one << 32) - 1))
    return asNumbers<std::uint32_t>(field, PCLPointField::UINT32);
  return asWords(field);
}

/** \brief Turns integers of 64 bits, which frames have no fields for, into numbers that
 * have the same values, or into two with the same bits. */
void
splitLongIntegers(PCLPointCloud2& cloud,
                  const LongIntegers& long_integers,
                  std::vector<std::string>& remarks)
{
  const auto isLong = [](const PCLPointField& field) {
    const FileField type = fileFieldOf(field);
    return type.bytes == 8 && type.kind != Kind::Real && field.name != "_";
  };
  if (std::none_of(cloud.fields.begin(), cloud.fields.end(), isLong))
    return;
  std::vector<MadeField> fields;
  for (const PCLPointField& field : cloud.fields) {
    if (!isLong(field)) {
      fields.push_back(copyOf(field));
      continue;
    }
    fields.push_back(asShorter(cloud, field, long_integers));
    const PCLPointField& made = fields.back().field;
    remarks.push_back("its field " + shownText(field.name) + " (" +
                      typeName(fileFieldOf(field)) + ") is taken as " +
                      (made.count == field.count
                           ? typeName(fileFieldOf(made)) + ", which has the same values"
                           : std::string("two uint32 with the same bits, as ") +
                                 (long_integers.one_of_several ? "uint32" : "float64") +
                                 " has not all of its values"));
  }
  setFields(fields, cloud);
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

/** \brief Values beyond the full one that are still rounded to 255. */
constexpr double most_above_full = 1.0 + 0.5 / 255.0;

/** \brief Which value of channels is full; none: they are no colours.
 * \param[in,out] of_stream that of the clouds before; is set by the first colour
 * \param[out] are_clamped some values are beyond that
 */
std::optional<double>
fullValue(const PCLPointCloud2& cloud,
          const std::vector<NumberReader>& channels,
          std::optional<double>& of_stream,
          bool& are_clamped)
{
  const auto isByte = [](const NumberReader& channel) {
    return channel.fileField().kind == Kind::Unsigned && channel.fileField().bytes == 1;
  };
  if (std::all_of(channels.begin(), channels.end(), isByte))
    return 255.0;
  double largest = 0.0;
  bool are_whole = true;
  const std::size_t points = std::size_t{cloud.width} * cloud.height;
  for (std::size_t i = 0; i < points; ++i)
    for (const NumberReader& channel : channels) {
      const double value = channel(cloud.data.data() + i * cloud.point_step);
      if (value < 0.0)
        return std::nullopt;
      if (!std::isfinite(value))
        continue; // of a missing point
      largest = std::max(largest, value);
      are_whole &= value == std::floor(value);
    }
  if (of_stream) {
    are_clamped |= largest > *of_stream * most_above_full;
    return of_stream;
  }
  const bool are_shares =
      std::any_of(channels.begin(), channels.end(), [](const NumberReader& channel) {
        return channel.fileField().kind == Kind::Real;
      });
  std::optional<double> full;
  if (are_shares && largest <= most_above_full)
    full = 1.0;
  else if (largest <= 255.0)
    full = 255.0;
  else if (are_whole && largest <= 65535.0)
    full = 65535.0;
  if (largest > 0.0)
    of_stream = full;
  return full;
}

/** \brief The channels of a colour in a cloud. */
struct Channels {
  std::vector<const PCLPointField*> fields; ///< red, green, blue
  const PCLPointField* alpha = nullptr;     ///< null: there is none
};

/** \brief The field of a channel, in any case of letters. */
const PCLPointField*
findChannel(const PCLPointCloud2& cloud, const std::string& name)
{
  for (const PCLPointField& field : cloud.fields)
    if (field.count == 1 && lowerCase(field.name) == name)
      return &field;
  return nullptr;
}

std::optional<Channels>
findChannels(const PCLPointCloud2& cloud)
{
  const std::array<std::string, 4> names[] = {
      {"red", "green", "blue", "alpha"},
      {"diffuse_red", "diffuse_green", "diffuse_blue", "alpha"},
      {"r", "g", "b", "a"}};
  for (const auto& of_channels : names) {
    Channels channels;
    for (std::size_t i = 0; i < 3; ++i)
      if (const PCLPointField* const field = findChannel(cloud, of_channels[i]))
        channels.fields.push_back(field);
    if (channels.fields.size() < 3)
      continue;
    channels.alpha = findChannel(cloud, of_channels[3]);
    return channels;
  }
  return std::nullopt;
}

/** \brief A number of a channel in 8 bits. */
std::uint32_t
channelOf(double value, double full)
{
  if (full == 255.0 && value <= full && value == std::floor(value))
    return static_cast<std::uint32_t>(value);
  return std::isfinite(value) ? static_cast<std::uint32_t>(
                                    std::lround(255.0 * std::min(value / full, 1.0)))
                              : 0;
}

/** \brief The packed colour of channels. */
MadeField
packedColour(const std::vector<NumberReader>& channels,
             double full,
             const std::optional<NumberReader>& alpha,
             double full_alpha)
{
  MadeField made;
  made.field.name = alpha ? "rgba" : "rgb";
  made.field.datatype = alpha ? PCLPointField::UINT32 : PCLPointField::FLOAT32;
  made.field.count = 1;
  made.bytes = sizeof(std::uint32_t);
  made.make = [=](const std::uint8_t* from, std::uint8_t* to) {
    std::uint32_t colour = alpha ? channelOf((*alpha)(from), full_alpha) : 255;
    for (const NumberReader& channel : channels)
      colour = colour << 8 | channelOf(channel(from), full);
    std::memcpy(to, &colour, sizeof(colour));
  };
  return made;
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
    if (!is_known || small == field.name || find(cloud, small) != nullptr)
      continue;
    given += (given.empty() ? "" : ", ") + field.name;
    usual += (usual.empty() ? "" : ", ") + small;
    field.name = small;
  }
  if (!given.empty())
    remarks.push_back("its fields " + given + " are taken as " + usual);
}

std::string
packColours(PCLPointCloud2& cloud,
            bool is_ply,
            ColourScale& scale,
            std::vector<std::string>& remarks)
{
  std::optional<Channels> found = findChannels(cloud);
  if (!found || find(cloud, "rgb") != nullptr || find(cloud, "rgba") != nullptr)
    return {};
  std::string names;
  std::vector<NumberReader> channels;
  for (const PCLPointField* const field : found->fields) {
    channels.emplace_back(*field);
    names += (names.empty() ? "" : ", ") + shownText(field->name);
  }
  bool are_clamped = false;
  const std::optional<double> full =
      fullValue(cloud, channels, scale.colour, are_clamped);
  if (!full)
    return {};
  std::optional<NumberReader> alpha;
  if (found->alpha != nullptr)
    alpha.emplace(*found->alpha);
  const std::optional<double> full_alpha =
      alpha ? fullValue(cloud, {*alpha}, scale.alpha, are_clamped) : std::nullopt;
  if (!full_alpha) {
    alpha.reset();
    found->alpha = nullptr;
  }
  std::vector<MadeField> fields;
  bool is_packed = false;
  for (const PCLPointField& field : cloud.fields) {
    const bool is_channel =
        std::find(found->fields.begin(), found->fields.end(), &field) !=
        found->fields.end();
    if (is_channel && !is_packed)
      fields.push_back(
          packedColour(channels, *full, alpha, full_alpha.value_or(255.0)));
    is_packed |= is_channel;
    if (!is_channel && &field != found->alpha)
      fields.push_back(copyOf(field));
  }
  const FileField type = channels[0].fileField();
  setFields(fields, cloud);
  if (!is_ply || type.bytes != 1)
    remarks.push_back("its fields " + names + " (" + typeName(type) +
                      ") are taken as its colour" +
                      (type.bytes == 1 ? ""
                                       : ", in 8 bits a channel, of 0 to " +
                                             std::to_string(static_cast<int>(*full))));
  return are_clamped ? "its fields " + names +
                           " have larger values than the first colours of the stream, "
                           "which tell the scale: these are clamped"
                     : "";
}

std::vector<std::string>
makeUsual(PCLPointCloud2& cloud,
          bool is_ply,
          ColourScale& scale,
          const LongIntegers& long_integers)
{
  std::vector<std::string> remarks;
  nameUsually(cloud, remarks);
  tellNamesOfSeveral(cloud, remarks);
  makeCoordinatesReal(cloud, remarks);
  makePackedColourUnsigned(cloud);
  if (const std::string clamped = packColours(cloud, is_ply, scale, remarks);
      !clamped.empty())
    remarks.push_back(clamped);
  splitLongIntegers(cloud, long_integers, remarks);
  return remarks;
}

} // namespace clouds
} // namespace pcl_ext
