#include "stream_results.h"

#include <pcl_ext/compression/frame_decoder.h>

#include "coding_costs.h"
#include "measuring/samples.h"

#include <stdexcept>

namespace pcl_ext {
namespace report {

namespace {

using measuring::Samples;
using measuring::timeOf;

/** \brief One coder of a stream, and its results. */
class CoderRun {
public:
  CoderRun(const StreamCoder& coder, double frame_rate)
  : subject_(coder.subject), node_(coder.settings), costs_(frame_rate)
  {}

  void
  code(const pcl::PCLPointCloud2& cloud, const WorldPose& pose)
  {
    nodes::SensorNodeStatus status;
    const double encode_ms =
        timeOf([&] { status = node_.encode(cloud, pose, bytes_); });
    if (!status.hasFrame())
      throw std::runtime_error(name() + ": " + status.message());
    io::CompressionStatus decoded;
    const double decode_ms = timeOf(
        [&] { decoded = decoder_.decode(bytes_.data(), bytes_.size(), voxels_); });
    const io::FrameStatistics frame = node_.statistics().frame;
    if (!decoded.ok() || voxels_.size() != frame.coding.voxels)
      throw std::runtime_error(name() +
                               ": the decoded frame differs: " + decoded.message());
    voxel_count_.add(static_cast<double>(frame.coding.voxels));
    bytes_per_voxel_.add(frame.bytesPerVoxel());
    costs_.add(bytes_.size(),
               static_cast<double>(frame.voxelization.points_used),
               encode_ms,
               decode_ms);
  }

  void
  write(measuring::ResultFile& results) const
  {
    results.add(subject_, "voxels", voxel_count_);
    results.add(subject_, "bytes_per_voxel", bytes_per_voxel_);
    costs_.write(subject_, results);
  }

private:
  std::string
  name() const
  {
    return subject_.sensor + ", " + subject_.coder;
  }

  measuring::Subject subject_;
  nodes::SensorNode node_;
  io::FrameDecoder decoder_;
  std::vector<std::uint8_t> bytes_;
  io::VoxelFrame voxels_;

  Samples voxel_count_;
  Samples bytes_per_voxel_;
  CodingCosts costs_;
};

} // namespace

void
measureCoders(const measuring::InputStream& stream,
              double frame_rate,
              const std::vector<StreamCoder>& coders,
              measuring::ResultFile& results)
{
  std::vector<CoderRun> runs;
  for (const StreamCoder& coder : coders)
    runs.emplace_back(coder, frame_rate);
  pcl::PCLPointCloud2 cloud;
  for (std::size_t i = 0; i < stream.clouds->size(); ++i) {
    stream.clouds->read(i, cloud);
    const WorldPose pose(stream.clouds->sensorPoseAt(i));
    for (CoderRun& run : runs)
      run.code(cloud, pose);
  }
  for (const CoderRun& run : runs)
    run.write(results);
}

void
measureCropping(const measuring::InputStream& stream,
                const measuring::Subject& subject,
                measuring::ResultFile& results)
{
  const auto preprocess =
      measuring::makePreprocessing<pcl::PCLPointCloud2>(IntensityLaw::Count,
                                                        subject.resolution,
                                                        std::nullopt,
                                                        stream.clouds->sensorPose(),
                                                        stream.crop_box);
  pcl::PCLPointCloud2 cloud;
  measuring::IntensityCloud cropped;
  Samples cloud_points, points, cropped_points, cropping_ratio, kept_percent,
      preprocess_ms;
  for (std::size_t i = 0; i < stream.clouds->size(); ++i) {
    stream.clouds->read(i, cloud);
    PreprocessingStatistics statistics;
    preprocess_ms.add(timeOf([&] { statistics = preprocess(cloud, cropped); }));
    const double all = static_cast<double>(statistics.points);
    const double finite = all - static_cast<double>(statistics.points_not_finite);
    const double inside = static_cast<double>(cropped.size());
    cloud_points.add(all);
    points.add(finite);
    cropped_points.add(inside);
    cropping_ratio.add(all / inside);
    kept_percent.add(100.0 * inside / finite);
  }
  results.add(subject, "cloud_points", cloud_points);
  results.add(subject, "points", points);
  results.add(subject, "cropped_points", cropped_points);
  results.add(subject, "cropping_ratio", cropping_ratio);
  results.add(subject, "kept_percent", kept_percent);
  results.add(subject, "preprocess_ms", preprocess_ms);
}

} // namespace report
} // namespace pcl_ext
