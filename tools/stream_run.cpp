#include "stream_run.h"

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/filters/sensor_preprocessor.h>

#include <pcl/filters/passthrough.h>
#include <pcl/io/pcd_io.h>

#include <boost/timer/progress_display.hpp>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <iomanip>
#include <iostream>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace pcl_ext {
namespace tools {

namespace {

namespace fs = std::filesystem;

using IntensityCloud = pcl::PointCloud<pcl::PointXYZI>;
using Compression = io::OctreePointCloudIntensityCompression<pcl::PointXYZI>;

/** \brief Adds the time from its construction to its destruction to a sum. */
class Stopwatch {
public:
  explicit Stopwatch(double& milliseconds)
  : milliseconds_(milliseconds), start_(std::chrono::steady_clock::now())
  {}

  ~Stopwatch()
  {
    milliseconds_ += std::chrono::duration<double, std::milli>(
                         std::chrono::steady_clock::now() - start_)
                         .count();
  }

private:
  double& milliseconds_;
  std::chrono::steady_clock::time_point start_;
};

/** \brief A preprocessor whose law was chosen when the program ran. */
using Preprocessing =
    std::function<PreprocessingStatistics(const pcl::PCLPointCloud2&, IntensityCloud&)>;

template <typename LawT>
Preprocessing
makePreprocessing(const StreamOptions& options,
                  const Eigen::Isometry3d& sensor_pose,
                  const std::optional<io::BoundingBox>& crop_box)
{
  using Model = IntensityModel<RuntimeSensor, LawT>;
  SensorPreprocessor<Model> preprocessor(
      Model(options.settings.resolution, options.sensor));
  preprocessor.setSensorPose(sensor_pose);
  if (crop_box)
    preprocessor.setCropBox(
        Eigen::Map<const Eigen::Vector3d>(crop_box->min.data()).cast<float>(),
        Eigen::Map<const Eigen::Vector3d>(crop_box->max.data()).cast<float>());
  if (LawT::unit == IntensityUnit::Share)
    preprocessor.setIntensityScale(255.0f);
  return
      [preprocessor](const pcl::PCLPointCloud2& cloud, IntensityCloud& output) mutable {
        const PreprocessingStatus status = preprocessor.process(cloud, output);
        if (!status.ok())
          throw std::runtime_error(status.message());
        return preprocessor.getStatistics();
      };
}

Preprocessing
choosePreprocessing(Law law,
                    const StreamOptions& options,
                    const Eigen::Isometry3d& sensor_pose,
                    const std::optional<io::BoundingBox>& crop_box)
{
  switch (law) {
  case Law::Quadratic:
    return makePreprocessing<QuadraticLaw>(options, sensor_pose, crop_box);
  case Law::Linear:
    return makePreprocessing<LinearLaw>(options, sensor_pose, crop_box);
  case Law::Native:
    return makePreprocessing<NativeLaw>(options, sensor_pose, crop_box);
  case Law::Count:
  case Law::Automatic:
    break;
  }
  return makePreprocessing<CountLaw>(options, sensor_pose, crop_box);
}

const char*
nameOf(Law law)
{
  switch (law) {
  case Law::Quadratic:
    return "quadratic";
  case Law::Linear:
    return "linear";
  case Law::Native:
    return "native";
  case Law::Count:
  case Law::Automatic:
    break;
  }
  return "count";
}

Law
resolveLaw(Law law, const pcl::PCLPointCloud2& cloud)
{
  if (law != Law::Automatic)
    return law;
  const bool has_intensity =
      std::any_of(cloud.fields.begin(), cloud.fields.end(), [](const auto& field) {
        return field.name == "intensity";
      });
  return has_intensity ? Law::Native : Law::Count;
}

/** \brief Thresholds of the paper's Figure 11; a native intensity says nothing of
 * noise.
 */
float
defaultThreshold(Law law)
{
  switch (law) {
  case Law::Quadratic:
  case Law::Linear:
    return 64.0f;
  case Law::Native:
    return 0.0f;
  case Law::Count:
  case Law::Automatic:
    break;
  }
  return 2.0f;
}

/** \brief The preprocessed points carry their intensity, so the class takes it as the
 * points' own: summed for the laws of the paper, averaged for a native one. */
io::IntensityCompressionSettings
compressionSettings(const StreamOptions& options,
                    Law law,
                    const std::optional<io::BoundingBox>& crop_box)
{
  io::IntensityCompressionSettings settings = options.settings;
  settings.bounding_box = crop_box;
  if (law == Law::Native)
    return settings;
  settings.aggregation = io::Aggregation::Sum;
  if (settings.format == io::StreamFormat::Version1) {
    settings.intensity_bits =
        settings.intensity_bits != 0 ? settings.intensity_bits : 8;
    settings.intensity_range = 255.0f;
  }
  return settings;
}

void
denoise(const IntensityCloud::ConstPtr& decoded, float threshold, IntensityCloud& kept)
{
  pcl::PassThrough<pcl::PointXYZI> filter;
  filter.setInputCloud(decoded);
  filter.setFilterFieldName("intensity");
  filter.setFilterLimits(threshold, std::numeric_limits<float>::max());
  filter.filter(kept);
}

/** \brief Writes a cloud for pcl_viewer; none if it holds no point, which PCD cannot
 * say.
 */
void
writeCloud(const fs::path& folder, std::size_t index, const IntensityCloud& cloud)
{
  if (cloud.empty())
    return;
  std::ostringstream name;
  name << std::setw(4) << std::setfill('0') << index << ".pcd";
  if (pcl::io::savePCDFileBinaryCompressed((folder / name.str()).string(), cloud) != 0)
    throw std::runtime_error("cannot write '" + (folder / name.str()).string() + "'");
}

void
check(const io::CompressionStatus& status, const char* action, std::size_t index)
{
  if (!status.ok())
    throw std::runtime_error(std::string(action) + " frame " + std::to_string(index) +
                             " failed: " + status.message());
}

} // namespace

StreamReport
runStream(CloudSequence& sequence,
          const StreamOptions& options,
          const std::optional<io::BoundingBox>& crop_box)
{
  StreamReport report;
  report.name = sequence.name();
  pcl::PCLPointCloud2 cloud;
  sequence.read(0, cloud);
  const Law law = resolveLaw(options.law, cloud);
  report.law = nameOf(law);
  Preprocessing preprocess =
      choosePreprocessing(law, options, sequence.sensorPose(), crop_box);
  const io::IntensityCompressionSettings settings =
      compressionSettings(options, law, crop_box);
  Compression encoder(settings);
  Compression decoder(settings);
  const float threshold = options.threshold.value_or(defaultThreshold(law));
  const fs::path folder = fs::path(options.output_folder) / report.name;
  if (!options.output_folder.empty()) {
    fs::create_directories(folder / "decoded");
    fs::create_directories(folder / "denoised");
  }

  std::cerr << report.name << ": " << sequence.size() << " frames\n";
  boost::timer::progress_display progress(sequence.size(), std::cerr);
  const IntensityCloud::Ptr preprocessed(new IntensityCloud);
  IntensityCloud::Ptr decoded(new IntensityCloud);
  IntensityCloud kept;
  for (std::size_t index = 0; index < sequence.size(); ++index, ++progress) {
    sequence.read(index, cloud);
    PreprocessingStatistics preprocessing;
    {
      const Stopwatch stopwatch(report.preprocess_ms);
      preprocessing = preprocess(cloud, *preprocessed);
    }
    std::stringstream bytes;
    {
      const Stopwatch stopwatch(report.encode_ms);
      check(encoder.encodePointCloud(preprocessed, bytes), "encoding", index);
    }
    {
      const Stopwatch stopwatch(report.decode_ms);
      check(decoder.decodePointCloud(bytes, decoded), "decoding", index);
    }
    {
      const Stopwatch stopwatch(report.denoise_ms);
      denoise(decoded, threshold, kept);
    }
    if (encoder.getVoxelFrame().keys != decoder.getVoxelFrame().keys ||
        encoder.getVoxelFrame().intensities != decoder.getVoxelFrame().intensities)
      throw std::runtime_error("frame " + std::to_string(index) +
                               " was not decoded to what was encoded");
    if (!options.output_folder.empty()) {
      writeCloud(folder / "decoded", index, *decoded);
      writeCloud(folder / "denoised", index, kept);
    }
    ++report.frames;
    report.points += preprocessing.points - preprocessing.points_not_finite;
    report.cropped_points += preprocessed->size();
    report.voxels += decoded->size();
    report.kept_voxels += kept.size();
    report.bytes += encoder.getStatistics().coding.bytes;
  }
  return report;
}

} // namespace tools
} // namespace pcl_ext
