#include "measuring/sensor_streams.h"

#include <stdexcept>

namespace pcl_ext {
namespace measuring {

nodes::SensorNodeSettings
sensorNodeSettings(const InputStream& stream,
                   const Workload& workload,
                   const Variant& variant)
{
  nodes::SensorNodeSettings settings;
  settings.law = IntensityLaw::Count;
  settings.compression.resolution = workload.resolution;
  settings.compression.i_frame_rate = workload.i_frame_rate;
  settings.compression.effort = variant.effort;
  settings.compression.format = variant.format;
  settings.compression.colour_bits = 0;
  settings.crop_box = stream.crop_box;
  settings.outlier_removal = workload.outlier_removal;
  return settings;
}

SensorStream
encodeStream(const InputStream& stream,
             const Workload& workload,
             const Variant& variant)
{
  nodes::SensorNode node(sensorNodeSettings(stream, workload, variant));
  SensorStream encoded;
  encoded.name = stream.clouds->name();
  pcl::PCLPointCloud2 cloud;
  for (std::size_t i = 0; i < stream.clouds->size(); ++i) {
    stream.clouds->read(i, cloud);
    const WorldPose pose(stream.clouds->sensorPoseAt(i));
    std::vector<std::uint8_t> bytes;
    if (const auto status = node.encode(cloud, pose, bytes); !status.hasFrame())
      throw std::runtime_error(encoded.name + ": " + status.message());
    const io::CodedFrameStatistics coding = node.statistics().frame.coding;
    if (coding.is_i_frame)
      encoded.i_frames.push_back(i);
    encoded.bytes += bytes.size();
    encoded.voxels += coding.voxels;
    encoded.frames.push_back(std::move(bytes));
  }
  return encoded;
}

} // namespace measuring
} // namespace pcl_ext
