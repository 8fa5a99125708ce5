#include "streams/filtered_stream.h"

#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "measuring/samples.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace tools {

namespace {

using measuring::timeOf;

nodes::SensorNodeSettings
withFilter(nodes::SensorNodeSettings settings)
{
  settings.compression.temporal_filter = TemporalVoxelFilter::usual_frames;
  return settings;
}

bool
isIn(const io::VoxelFrame& frame, std::uint64_t key)
{
  return std::binary_search(frame.keys.begin(), frame.keys.end(), key);
}

/** \brief True if a frame has a voxel or one of the 26 around it. */
bool
isWithinOneVoxelOf(const io::VoxelFrame& frame, std::uint64_t key)
{
  if (isIn(frame, key))
    return true;
  const io::VoxelPosition at = io::voxelPosition(key);
  const auto size = static_cast<std::uint32_t>(frame.grid.size());
  // Beyond either end of the grid a coordinate is not below its size.
  for (std::uint32_t x = at.x - 1; x != at.x + 2; ++x)
    for (std::uint32_t y = at.y - 1; y != at.y + 2; ++y)
      for (std::uint32_t z = at.z - 1; z != at.z + 2; ++z)
        if (x < size && y < size && z < size && isIn(frame, io::mortonKey({x, y, z})))
          return true;
  return false;
}

} // namespace

FilteredStream::FilteredStream(nodes::SensorNodeSettings settings,
                               const WorldPose& pose)
: node_(withFilter(std::move(settings))), pose_(pose)
{
  report_.frames_of_filter = TemporalVoxelFilter::usual_frames;
}

void
FilteredStream::run(const pcl::PCLPointCloud2& cloud,
                    const io::VoxelFrame& unfiltered,
                    const std::vector<noise::VoxelTruth>* truth)
{
  nodes::SensorNodeStatus encoding;
  report_.encode_ms += timeOf([&] { encoding = node_.encode(cloud, pose_, bytes_); });
  if (!encoding.hasFrame())
    throw std::runtime_error("encoding failed: " + encoding.message());
  io::CompressionStatus decoding;
  report_.decode_ms +=
      timeOf([&] { decoding = decoder_.decode(bytes_.data(), bytes_.size(), shown_); });
  if (!decoding.ok())
    throw std::runtime_error("decoding failed: " + decoding.message());
  report_.voxels += shown_.size();
  report_.bytes += bytes_.size();
  if (truth != nullptr && shown_.grid == unfiltered.grid)
    compare(unfiltered, *truth);
}

void
FilteredStream::compare(const io::VoxelFrame& unfiltered,
                        const std::vector<noise::VoxelTruth>& truth)
{
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const std::uint64_t key = unfiltered.keys[i];
    if (truth[i] == noise::VoxelTruth::Noise) {
      ++report_.noise;
      report_.noise_hidden += isIn(shown_, key) ? 0 : 1;
    }
    else {
      ++report_.surfaces;
      report_.surfaces_shown += isWithinOneVoxelOf(shown_, key) ? 1 : 0;
    }
  }
}

} // namespace tools
} // namespace pcl_ext
