#include "stage_counts.h"

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/point_intensity.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>

namespace pcl_ext {
namespace measuring {

namespace {

std::size_t
bytesOf(const io::VoxelFrame& frame)
{
  return frame.keys.size() * sizeof(frame.keys[0]) +
         frame.intensities.size() * sizeof(frame.intensities[0]);
}

template <typename PointT>
std::size_t
bytesOf(const pcl::PointCloud<PointT>& cloud)
{
  return cloud.size() * sizeof(PointT);
}

std::size_t
bytesOf(const std::vector<std::uint8_t>& bytes)
{
  return bytes.size();
}

VoxelOutlierRemovalSettings
outlierRemovalOf(const Workload& workload)
{
  VoxelOutlierRemovalSettings settings;
  settings.unit = densityUnitOf(workload.law);
  return settings;
}

/** \brief What a stage took of a frame, before it is known how many voxels that has. */
struct StageSample {
  const char* name;
  std::size_t points;
  std::size_t bytes_read;
  std::size_t bytes_written;
  double milliseconds;
  EventCounts events;
};

/** \brief All stages of one stream. */
class Stages {
public:
  Stages(const InputStream& stream,
         const Workload& workload,
         const Variant& variant,
         EventCounter& counter)
  : counter_(counter)
  , preprocess_(makePreprocessing(workload, stream))
  , sensor_pose_(stream.clouds->sensorPose())
  , encoder_(compressionSettings(workload, variant),
             IntensityUnit::Native,
             compressionSettings(workload, variant).depth_law)
  , outlier_removal_(outlierRemovalOf(workload))
  {}

  /** \brief Runs a frame through the stages.
   * \return figures in the order of the stages
   */
  const std::vector<StageSample>&
  run(const InputFrame& frame)
  {
    samples_.clear();
    // The cloud has just been written, as by a driver.
    raw_ = *frame.raw;
    measure("move and crop", raw_, points_, [&] { preprocess_(raw_, points_); });
    // The rest is of the cropped points.
    const io::PointView view = pointViewWithIntensities(points_);
    measure("voxelize", points_, voxels_, [&] {
      throwUnlessOk(encoder_.voxelize(view, sensor_pose_, voxels_));
    });
    kept_ = voxels_;
    measure("remove outliers", voxels_, kept_, [&] {
      if (const auto status = outlier_removal_.filter(kept_); !status.ok())
        throw std::runtime_error(status.message());
    });
    measure("code", voxels_, bytes_, [&] {
      throwUnlessOk(encoder_.encode(voxels_, std::nullopt, bytes_));
    });
    measure("decode", bytes_, decoded_, [&] {
      throwUnlessOk(decoder_.decode(bytes_.data(), bytes_.size(), decoded_));
    });
    measure("fill cloud", decoded_, cloud_, [&] {
      io::detail::fillCloud(decoded_, cloud_);
    });
    if (voxels_.keys != decoded_.keys || voxels_.intensities != decoded_.intensities)
      throw std::runtime_error("the decoded frame differs from the encoded one");
    return samples_;
  }

  std::size_t
  voxelCount() const
  {
    return voxels_.size();
  }

private:
  template <typename InputT, typename OutputT>
  void
  measure(const char* name,
          const InputT& input,
          const OutputT& output,
          const std::function<void()>& stage)
  {
    StageSample sample{name, 0, bytesOf(input), 0, 0.0, {}};
    sample.events = counter_.count([&] { sample.milliseconds = timeOf(stage); });
    sample.bytes_written = bytesOf(output);
    sample.points = samples_.empty() ? raw_.size() : points_.size();
    samples_.push_back(sample);
  }

  EventCounter& counter_;
  Preprocessing<PositionCloud> preprocess_;
  WorldPose sensor_pose_;
  io::CloudEncoder encoder_;
  VoxelOutlierRemoval outlier_removal_;
  io::FrameDecoder decoder_;
  PositionCloud raw_;
  IntensityCloud points_;
  io::VoxelFrame voxels_;
  io::VoxelFrame kept_;
  std::vector<std::uint8_t> bytes_;
  io::VoxelFrame decoded_;
  IntensityCloud cloud_;
  std::vector<StageSample> samples_;
};

void
addFrame(std::size_t index,
         const StageSample& sample,
         std::size_t voxels,
         StageCounts& stage)
{
  stage.name = sample.name;
  stage.points.keepLeast(index, static_cast<double>(sample.points));
  stage.voxels.keepLeast(index, static_cast<double>(voxels));
  stage.bytes_read.keepLeast(index, static_cast<double>(sample.bytes_read));
  stage.bytes_written.keepLeast(index, static_cast<double>(sample.bytes_written));
  stage.milliseconds.keepLeast(index, sample.milliseconds);
  for (std::size_t i = 0; i < sample.events.size(); ++i)
    if (sample.events[i])
      stage.events[i].keepLeast(index, *sample.events[i]);
}

} // namespace

std::vector<StageCounts>
countStages(const InputStream& stream,
            const Workload& workload,
            const Variant& variant,
            std::size_t repetitions,
            EventCounter& counter)
{
  const std::vector<InputFrame> frames = readFrames(stream, workload, Keep::All);
  std::vector<StageCounts> counts;
  for (std::size_t repetition = 0; repetition < repetitions; ++repetition) {
    Stages stages(stream, workload, variant, counter);
    for (std::size_t index = 0; index < frames.size(); ++index) {
      const std::vector<StageSample>& samples = stages.run(frames[index]);
      counts.resize(samples.size());
      for (std::size_t i = 0; i < samples.size(); ++i)
        addFrame(index, samples[i], stages.voxelCount(), counts[i]);
    }
  }
  return counts;
}

} // namespace measuring
} // namespace pcl_ext
