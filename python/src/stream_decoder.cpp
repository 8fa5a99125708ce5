#include "stream_decoder.h"

#include <new>

namespace pcl_ext {
namespace python {

io::CompressionStatus
StreamDecoder::decode(const std::uint8_t* bytes,
                      std::size_t size,
                      const Denoising& denoising,
                      std::optional<DecodedCloud>& cloud)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  cloud.reset();
  io::CompressionStatus status = decoder_.decode(bytes, size, frame_);
  if (!status.ok())
    return status;
  try {
    denoising.apply(frame_);
    cloud.emplace(frame_);
  }
  catch (const std::bad_alloc&) {
    return outOfMemoryStatus<io::CompressionStatus>();
  }
  return status;
}

std::vector<float>
StreamDecoder::score(OutlierFilter& outliers) const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<float> log_odds = outliers.score(frame_);
  if (!frame_.has_point_counts)
    return log_odds;
  std::vector<float> of_points;
  of_points.reserve(frame_.pointCount());
  for (std::size_t voxel = 0; voxel < frame_.size(); ++voxel)
    of_points.insert(of_points.end(), frame_.point_counts[voxel], log_odds[voxel]);
  return of_points;
}

std::optional<io::FrameStamp>
StreamDecoder::stamp() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return decoder_.stamp();
}

io::CodedFrameStatistics
StreamDecoder::statistics() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return decoder_.statistics();
}

} // namespace python
} // namespace pcl_ext
