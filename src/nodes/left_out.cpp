// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/left_out.h"

#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/nodes/impl/message_layouts.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "nodes/sensor_node_settings.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

/** \brief Whether FieldCollector keeps a field as a further one.
 * \param[in] offered those of the cloud that can be kept
 */
bool
isKept(const pcl::PCLPointField& field,
       const std::vector<FoundField>& offered,
       const SensorNodeSettings& settings)
{
  const auto first =
      std::find_if(offered.begin(), offered.end(), [&field](const FoundField& other) {
        return other.description.name == field.name;
      });
  const auto found =
      std::find_if(first, offered.end(), [&field](const FoundField& other) {
        return other.description.name == field.name && other.offset == field.offset;
      });
  if (found == offered.end())
    return false;
  const auto& kept = settings.compression.fields;
  return std::any_of(kept.begin(), kept.end(), [&](const io::FieldSetting& setting) {
    return setting.name == io::all_fields
               ? io::isOneOfAllFields(found->description, codesColours(settings))
               : setting.name == field.name && found == first;
  });
}

/** \brief Whether a field has other bytes than the first one of its name, which is the
 * one that is read. */
bool
isAnother(const pcl::PCLPointCloud2& cloud, const pcl::PCLPointField& field)
{
  const auto first =
      std::find_if(cloud.fields.begin(),
                   cloud.fields.end(),
                   [&field](const auto& other) { return other.name == field.name; });
  return first->offset != field.offset;
}

/** \brief True for a field that is encoded, and for what fills gaps between fields. The
 * law decides on the intensity, which is therefore never left out without being asked
 * for, unless it cannot be read. */
bool
isMeant(const pcl::PCLPointCloud2& cloud,
        const pcl::PCLPointField& field,
        const PointLayout& layout,
        const SensorNodeSettings& settings)
{
  const bool is_coordinate =
      field.name == "x" || field.name == "y" || field.name == "z";
  const bool has_name_of_colour = field.name == "rgb" || field.name == "rgba";
  const bool is_colour =
      has_name_of_colour && layout.has_colour && field.offset == layout.colour;
  const bool is_unwanted_colour =
      has_name_of_colour && settings.compression.colour_bits == 0 &&
      settings.compression.format == io::StreamFormat::Version1;
  const bool is_intensity =
      field.name == settings.intensity_field && hasReadableField(cloud, field.name);
  return ((is_coordinate || is_intensity) && !isAnother(cloud, field)) || is_colour ||
         is_unwanted_colour || field.name == "_";
}

/** \brief True for a colour with an alpha that is lost: frames have red, green and blue,
 * and decoded points are opaque. The bits of the field `rgb` that would be alpha mean
 * nothing. Of all fields of points the frame's own status tells it, as its voxels keep
 * the field and a scan does not. */
bool
losesAlpha(const pcl::PCLPointCloud2& cloud,
           const pcl::PCLPointField& field,
           const PointLayout& layout,
           const io::EncoderSettings& settings)
{
  const bool is_told =
      settings.keepsPoints() &&
      std::any_of(settings.fields.begin(), settings.fields.end(), [](const auto& kept) {
        return kept.name == io::all_fields;
      });
  if (is_told || field.name != "rgba" || !layout.has_colour ||
      field.offset != layout.colour)
    return false;
  const std::size_t row_step = rowStep(cloud);
  for (std::size_t row = 0; row < cloud.height; ++row)
    for (std::size_t column = 0; column < cloud.width; ++column) {
      std::uint32_t colour = 0;
      std::memcpy(
          &colour,
          &cloud.data[row * row_step + column * cloud.point_step + field.offset],
          sizeof(colour));
      if (colour >> 24 != 0xff)
        return true;
    }
  return false;
}

std::string
namesOfLeftOut(const pcl::PCLPointCloud2& cloud,
               const PointLayout& layout,
               const SensorNodeSettings& settings)
{
  constexpr std::size_t most_named = 16;
  constexpr std::size_t longest_listed_name = 64;
  const std::vector<FoundField> offered = findFields(cloud);
  std::string names;
  std::size_t count = 0;
  bool has_nameless = false;
  for (const pcl::PCLPointField& field : cloud.fields) {
    const bool is_kept = isKept(field, offered, settings);
    const bool loses_alpha =
        !is_kept && losesAlpha(cloud, field, layout, settings.compression);
    if (is_kept || (isMeant(cloud, field, layout, settings) && !loses_alpha) ||
        (field.name.empty() && has_nameless) || ++count > most_named)
      continue;
    has_nameless |= field.name.empty();
    names += (names.empty() ? "" : ", ") +
             (loses_alpha          ? "the alpha of rgba"
              : field.name.empty() ? "those without a name"
                                   : (isAnother(cloud, field) ? "another " : "") +
                                         field.name.substr(0, longest_listed_name));
  }
  return count > most_named ? names + ", ..." : names;
}

/** \brief That rows are not as long as the cloud tells; empty if they are. It is the
 * same for all clouds of a sensor, whatever their widths. */
std::string
describeRowStep(const pcl::PCLPointCloud2& cloud)
{
  return cloud.height == 0 || rowStep(cloud) == cloud.row_step
             ? std::string()
             : "row_step does not fit the rows, which follow each other without gaps, "
               "and is not used";
}

/** \brief That there are more bytes than points, a whole point or more. */
std::string
describeSurplus(const pcl::PCLPointCloud2& cloud)
{
  // The layout was checked, so that the product is at most the size of the data.
  return cloud.height == 0 ||
                 cloud.data.size() < rowStep(cloud) * cloud.height + cloud.point_step
             ? std::string()
             : "the bytes behind the last row are not used";
}

/** \brief That the layout of the message is not carried, though it should be. */
std::string
describeLayout(const pcl::PCLPointCloud2& cloud, const SensorNodeSettings& settings)
{
  return !settings.carry_layout || cloud.data.empty() ||
                 settings.compression.format == io::StreamFormat::Published ||
                 io::isLayout(layoutToCarry(cloud, settings))
             ? std::string()
             : "the layout of messages with " + std::to_string(cloud.point_step) +
                   " bytes a point is not kept";
}

bool
hasField(const pcl::PCLPointCloud2& cloud, const std::string& name)
{
  return std::any_of(cloud.fields.begin(),
                     cloud.fields.end(),
                     [&name](const auto& field) { return field.name == name; });
}

/** \brief That rows and columns are not kept, or may not be. */
std::string
describeOrder(const pcl::PCLPointCloud2& cloud, const SensorNodeSettings& settings)
{
  if (cloud.height <= 1)
    return {};
  const std::string points = "the rows and columns of the points are ";
  if (settings.compression.keep_order)
    return cloud.width == 1 ? "the one column of points is kept as one row" : "";
  if (!settings.compression.keepsPoints())
    return points + "not kept";
  const bool judges_voxels =
      settings.outlier_removal &&
      !std::holds_alternative<AutomaticUnit>(settings.outlier_removal->unit);
  return points + (judges_voxels ? "not kept, as outliers are removed from voxels"
                                 : "kept only where that takes hardly more bytes");
}

} // namespace

std::string
describeLeftOut(const pcl::PCLPointCloud2& cloud, const SensorNodeSettings& settings)
{
  PointLayout layout;
  if (!findPointLayout(cloud,
                       settings.intensity_field,
                       settings.law == IntensityLaw::Native,
                       codesColours(settings),
                       layout)
           .ok())
    return {};
  const std::string fields = namesOfLeftOut(cloud, layout, settings);
  std::string text = fields.empty() ? "" : "fields that are left out: " + fields;
  for (const std::string& other : {describeCoordinates(layout.types),
                                   describeOrder(cloud, settings),
                                   describeRowStep(cloud),
                                   describeSurplus(cloud),
                                   describeLayout(cloud, settings)})
    if (!other.empty())
      text += (text.empty() ? "" : "; ") + other;
  return text;
}

io::MessageLayout
layoutToCarry(const pcl::PCLPointCloud2& cloud, const SensorNodeSettings& settings)
{
  io::MessageLayout layout = messageLayoutOf(cloud);
  const auto comes_back = [&settings](const io::PlacedField& field) {
    const auto& kept = settings.compression.fields;
    const auto is_named = [&field](const io::FieldSetting& setting) {
      return setting.name == io::all_fields || setting.name == field.name;
    };
    return field.name == "x" || field.name == "y" || field.name == "z" ||
           field.name == "rgb" || field.name == "rgba" ||
           field.name == settings.intensity_field ||
           std::any_of(kept.begin(), kept.end(), is_named);
  };
  layout.fields.erase(std::remove_if(layout.fields.begin(),
                                     layout.fields.end(),
                                     [&comes_back](const io::PlacedField& field) {
                                       return !comes_back(field);
                                     }),
                      layout.fields.end());
  return layout;
}

std::string
faultOfNamedFields(const pcl::PCLPointCloud2& cloud,
                   const std::vector<io::FieldSetting>& settings)
{
  if (settings.empty())
    return {};
  const std::vector<FoundField> offered = findFields(cloud);
  for (const io::FieldSetting& setting : settings) {
    if (setting.name == io::all_fields || !hasField(cloud, setting.name) ||
        std::any_of(
            offered.begin(), offered.end(), [&setting](const FoundField& field) {
              return field.description.name == setting.name;
            }))
      continue;
    return "field '" + setting.name +
           "' cannot be kept: it is a coordinate or a gap, its datatype is none of " +
           "int8 to uint32, float32 and float64, or it is not within a point";
  }
  return {};
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
