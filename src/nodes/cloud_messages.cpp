#include <pcl_ext/nodes/cloud_messages.h>

#include <array>
#include <cstring>

namespace pcl_ext {
namespace nodes {

namespace {

constexpr const char* format_of_version1 = "pcl_ext/version1";
constexpr const char* format_of_published = "pcl_ext/published";

/** \brief Writes the further fields of a point.
 * \return after the last byte
 */
std::uint8_t*
writeFields(const io::VoxelFrame& frame, std::size_t point, std::uint8_t* data)
{
  for (const io::FrameField& field : frame.fields)
    for (std::size_t i = 0; i < field.count; ++i) {
      io::fieldValue(field, field.numbers[point * field.count + i], data);
      data += io::sizeOf(field.type);
    }
  return data;
}

} // namespace

const char*
messageFormat(io::StreamFormat format)
{
  return format == io::StreamFormat::Published ? format_of_published
                                               : format_of_version1;
}

std::string
withoutLeadingSlash(const std::string& frame_id)
{
  return !frame_id.empty() && frame_id.front() == '/' ? frame_id.substr(1) : frame_id;
}

std::string
faultOfFormat(const std::string& format)
{
  return format == format_of_version1 || format == format_of_published
             ? ""
             : "unknown format '" + format + "'";
}

VoxelPointLayout
layoutOf(const io::VoxelFrame& frame)
{
  return {frame.pointCount(),
          frame.colour_bits > 0,
          frame.grid.needsDoubles(),
          {frame.fields.begin(), frame.fields.end()}};
}

void
writeVoxelPoints(const io::VoxelFrame& frame, std::uint8_t* data)
{
  const VoxelPointLayout layout = layoutOf(frame);
  const bool has_intensity = layout.hasVoxelIntensity();
  const bool has_colour = layout.hasVoxelColour();
  std::size_t voxel = 0;
  std::size_t point = 0;
  io::forEachPreciseCentre(frame, [&](auto x, auto y, auto z, float intensity) {
    const std::uint8_t* const first = data;
    const std::array<decltype(x), 3> place{x, y, z};
    const auto append = [&data](const auto& element) {
      std::memcpy(data, &element, sizeof(element));
      data += sizeof(element);
    };
    append(place);
    if (has_intensity)
      append(intensity);
    if (has_colour) {
      const io::VoxelColour colour = frame.fullColour(voxel);
      const std::uint32_t packed =
          std::uint32_t{colour.r} << 16 | std::uint32_t{colour.g} << 8 | colour.b;
      append(packed);
    }
    const auto of_voxel = static_cast<std::size_t>(data - first);
    data = writeFields(frame, point++, data);
    for (std::uint32_t i = 1; frame.has_point_counts && i < frame.point_counts[voxel];
         ++i) {
      std::memcpy(data, first, of_voxel);
      data = writeFields(frame, point++, data + of_voxel);
    }
    ++voxel;
  });
}

} // namespace nodes
} // namespace pcl_ext
