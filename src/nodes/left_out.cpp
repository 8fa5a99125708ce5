#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "nodes/sensor_node_settings.h"

#include <algorithm>

namespace pcl_ext {
namespace nodes {

namespace {

/** \brief True for a field that is encoded, and for what fills gaps between fields. The
 * law decides on the intensity, which is therefore never left out without being asked
 * for. */
bool
isMeant(const pcl::PCLPointField& field,
        const PointLayout& layout,
        const SensorNodeSettings& settings)
{
  const bool is_coordinate =
      field.offset == layout.x || field.offset == layout.y || field.offset == layout.z;
  const bool is_colour = layout.has_colour && field.offset == layout.colour;
  const bool is_unwanted_colour =
      (field.name == "rgb" || field.name == "rgba") &&
      settings.compression.colour_bits == 0 &&
      settings.compression.format == io::StreamFormat::Version1;
  const auto& kept = settings.compression.fields;
  const bool is_kept =
      std::any_of(kept.begin(), kept.end(), [&field](const io::FieldSetting& setting) {
        return setting.name == field.name || setting.name == io::all_fields;
      });
  return is_kept || is_coordinate || is_colour || is_unwanted_colour ||
         field.name == "_" || field.name == settings.intensity_field;
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
  constexpr std::size_t most_named = 16;
  constexpr std::size_t longest_name = 64;
  std::string fields;
  std::size_t count = 0;
  for (const pcl::PCLPointField& field : cloud.fields)
    if (!isMeant(field, layout, settings) && ++count <= most_named)
      fields += (fields.empty() ? "" : ", ") + field.name.substr(0, longest_name);
  if (count > most_named)
    fields += ", ...";
  const std::string order =
      cloud.height > 1 ? "the rows and columns of the points are not kept" : "";
  if (fields.empty())
    return order;
  return "fields that are left out: " + fields + (order.empty() ? "" : "; ") + order;
}

} // namespace nodes
} // namespace pcl_ext
