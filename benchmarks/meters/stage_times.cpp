#include "meters/stage_times.h"

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/point_intensity.h>

#include <cstdint>
#include <optional>
#include <stdexcept>

namespace pcl_ext {
namespace measuring {

namespace {

VoxelOutlierRemovalSettings
outlierRemovalOf(const Workload& workload)
{
  VoxelOutlierRemovalSettings settings;
  settings.unit = densityUnitOf(workload.law);
  return settings;
}

/** \brief All stages of one stream. */
class Stages {
public:
  Stages(const InputStream& stream, const Workload& workload, const Variant& variant)
  : preprocess_(makePreprocessing(workload, stream))
  , sensor_pose_(stream.clouds->sensorPose())
  , encoder_(compressionSettings(workload, variant),
             IntensityUnit::Native,
             compressionSettings(workload, variant).depth_law)
  , outlier_removal_(outlierRemovalOf(workload))
  {}

  /** \brief Runs a frame through the stages.
   * \param[in,out] times of the stages, in their order
   */
  void
  run(std::size_t index, const InputFrame& frame, std::vector<StageTimes>& times)
  {
    std::size_t stage = 0;
    const auto time = [&](const char* name, const auto& action) {
      times.resize(std::max(times.size(), stage + 1));
      times[stage].name = name;
      times[stage].milliseconds.keepLeast(index, timeOf(action));
      ++stage;
    };
    // The cloud has just been written, as by a driver.
    raw_ = *frame.raw;
    time("move and crop", [&] { preprocess_(raw_, points_); });
    const io::PointView view = pointViewWithIntensities(points_);
    time("voxelize",
         [&] { throwUnlessOk(encoder_.voxelize(view, sensor_pose_, voxels_)); });
    kept_ = voxels_;
    time("remove outliers", [&] {
      if (const auto status = outlier_removal_.filter(kept_); !status.ok())
        throw std::runtime_error(status.message());
    });
    time("code",
         [&] { throwUnlessOk(encoder_.encode(voxels_, std::nullopt, bytes_)); });
    time("decode", [&] {
      throwUnlessOk(decoder_.decode(bytes_.data(), bytes_.size(), decoded_));
    });
    time("fill cloud", [&] { io::detail::fillCloud(decoded_, cloud_); });
    if (voxels_.keys != decoded_.keys || voxels_.intensities != decoded_.intensities)
      throw std::runtime_error("the decoded frame differs from the encoded one");
    for (StageTimes& stage_times : times) {
      const bool is_first = &stage_times == &times.front();
      stage_times.points.keepLeast(
          index, static_cast<double>(is_first ? raw_.size() : points_.size()));
      stage_times.voxels.keepLeast(index, static_cast<double>(voxels_.size()));
    }
  }

private:
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
};

} // namespace

std::vector<StageTimes>
timeStages(const InputStream& stream,
           const Workload& workload,
           const Variant& variant,
           std::size_t repetitions)
{
  const std::vector<InputFrame> frames = readFrames(stream, workload, Keep::All);
  std::vector<StageTimes> times;
  for (std::size_t repetition = 0; repetition < repetitions; ++repetition) {
    Stages stages(stream, workload, variant);
    for (std::size_t index = 0; index < frames.size(); ++index)
      stages.run(index, frames[index], times);
  }
  return times;
}

} // namespace measuring
} // namespace pcl_ext
