#include "message_conversions.h"

#include <sensor_msgs/PointField.h>

#include <array>
#include <cstring>
#include <limits>
#include <utility>

namespace pcl_ext_ros {

namespace {

constexpr std::array<const char*, 5> field_names{"x", "y", "z", "intensity", "rgb"};
const std::string format_of_version1 = "pcl_ext/version1";
const std::string format_of_published = "pcl_ext/published";

/** \brief Writes header and layout of a cloud of voxels. PointCloud2 and
 * CompressedPointCloud2 have these fields in common. */
template <typename MessageT>
void
describeVoxels(const std_msgs::Header& header,
               std::size_t voxels,
               bool has_colours,
               MessageT& message)
{
  message.header = header;
  message.height = 1;
  message.width = static_cast<std::uint32_t>(voxels);
  message.fields.resize(field_names.size() - (has_colours ? 0 : 1));
  for (std::size_t i = 0; i < message.fields.size(); ++i) {
    message.fields[i].name = field_names[i];
    message.fields[i].offset = static_cast<std::uint32_t>(i * sizeof(float));
    message.fields[i].datatype = sensor_msgs::PointField::FLOAT32;
    message.fields[i].count = 1;
  }
  message.is_bigendian = false;
  message.point_step =
      static_cast<std::uint32_t>(sizeof(float) * message.fields.size());
  message.row_step = message.point_step * message.width;
  message.is_dense = true;
}

} // namespace

pcl_ext::nodes::Time
toNodeTime(const ros::Time& time)
{
  return std::chrono::seconds(time.sec) + std::chrono::nanoseconds(time.nsec);
}

ros::Time
toRosTime(pcl_ext::nodes::Time time)
{
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(time);
  if (time.count() < 0 || seconds.count() > std::numeric_limits<std::uint32_t>::max())
    return {};
  return {static_cast<std::uint32_t>(seconds.count()),
          static_cast<std::uint32_t>((time - seconds).count())};
}

pcl_ext::nodes::Time
rosTimeNow()
{
  return toNodeTime(ros::Time::now());
}

std::string
withoutLeadingSlash(const std::string& frame_id)
{
  const bool has_slash = !frame_id.empty() && frame_id.front() == '/';
  return frame_id.substr(has_slash ? 1 : 0);
}

CompressedPointCloud2
toMessage(const std_msgs::Header& header,
          pcl_ext::io::StreamFormat format,
          std::size_t voxels,
          bool has_colours,
          std::vector<std::uint8_t> bytes)
{
  CompressedPointCloud2 message;
  describeVoxels(header, voxels, has_colours, message);
  message.compressed_data = std::move(bytes);
  message.format = format == pcl_ext::io::StreamFormat::Published ? format_of_published
                                                                  : format_of_version1;
  return message;
}

bool
hasKnownFormat(const CompressedPointCloud2& message)
{
  return message.format == format_of_version1 || message.format == format_of_published;
}

sensor_msgs::PointCloud2
toMessage(const std_msgs::Header& header, const pcl_ext::io::VoxelFrame& frame)
{
  sensor_msgs::PointCloud2 message;
  const bool has_colours = frame.colour_bits > 0;
  describeVoxels(header, frame.size(), has_colours, message);
  message.data.resize(std::size_t{message.row_step});
  std::uint8_t* output = message.data.data();
  std::size_t voxel = 0;
  pcl_ext::io::forEachVoxelCentre(
      frame, [&](float x, float y, float z, float intensity) {
        const std::array<float, 4> point{x, y, z, intensity};
        std::memcpy(output, point.data(), sizeof(point));
        if (has_colours) {
          const pcl_ext::io::VoxelColour colour = frame.fullColour(voxel++);
          const std::uint32_t packed =
              std::uint32_t{colour.r} << 16 | std::uint32_t{colour.g} << 8 | colour.b;
          std::memcpy(output + sizeof(point), &packed, sizeof(packed));
        }
        output += message.point_step;
      });
  return message;
}

} // namespace pcl_ext_ros
