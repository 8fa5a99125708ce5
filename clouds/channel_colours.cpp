// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/channel_colours.h"

#include "clouds/file_text.h"
#include "clouds/made_fields.h"
#include "clouds/point_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace pcl_ext {
namespace clouds {

namespace {

using pcl::PCLPointCloud2;
using pcl::PCLPointField;

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
    return channel.fileField().kind == FieldKind::Unsigned &&
           channel.fileField().bytes == 1;
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
        return channel.fileField().kind == FieldKind::Real;
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

std::string
packColours(PCLPointCloud2& cloud,
            bool is_ply,
            ColourScale& scale,
            std::vector<std::string>& remarks)
{
  std::optional<Channels> found = findChannels(cloud);
  if (!found || findField(cloud, "rgb") != nullptr ||
      findField(cloud, "rgba") != nullptr)
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

} // namespace clouds
} // namespace pcl_ext
