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

/** \brief What the preprocessed intensities depend on, for the coder. */
std::optional<io::DepthLaw>
depthLaw(const StreamOptions& options, Law law)
{
  if (law != Law::Quadratic && law != Law::Linear)
    return std::nullopt;
  const IntensityModel<RuntimeSensor, QuadraticLaw> model(options.settings.resolution,
                                                          options.sensor);
  return io::DepthLaw{law == Law::Quadratic ? 2u : 1u, model.cutOffDepth(), 255.0};
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
    if (settings.intensity_bits == 0 &&
        settings.intensity_curve == io::IntensityCurve::Linear)
      settings.intensity_bits = 8;
    settings.intensity_range = 255.0f;
    settings.depth_law = depthLaw(options, law);
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

/** \brief The stages of one stream, and where their figures go. */
class Pipeline {
public:
  Pipeline(const StreamOptions& options,
           Law law,
           const Eigen::Isometry3d& sensor_pose,
           const std::optional<io::BoundingBox>& crop_box,
           StreamReport& report)
  : preprocess_(choosePreprocessing(law, options, sensor_pose, crop_box))
  , encoder_(compressionSettings(options, law, crop_box))
  , decoder_(compressionSettings(options, law, crop_box))
  , threshold_(options.threshold.value_or(defaultThreshold(law)))
  , report_(report)
  {}

  /** \brief Takes a cloud through all stages.
   * \throws std::runtime_error if one of them fails, or what was decoded is not what was
   * encoded
   */
  void
  run(const pcl::PCLPointCloud2& cloud)
  {
    PreprocessingStatistics preprocessing;
    {
      const Stopwatch stopwatch(report_.preprocess_ms);
      preprocessing = preprocess_(cloud, *preprocessed_);
    }
    std::stringstream bytes;
    {
      const Stopwatch stopwatch(report_.encode_ms);
      check(encoder_.encodePointCloud(preprocessed_, bytes), "encoding");
    }
    {
      const Stopwatch stopwatch(report_.decode_ms);
      check(decoder_.decodePointCloud(bytes, decoded_), "decoding");
    }
    {
      const Stopwatch stopwatch(report_.denoise_ms);
      denoise(decoded_, threshold_, denoised_);
    }
    if (encoder_.getVoxelFrame().keys != decoder_.getVoxelFrame().keys ||
        encoder_.getVoxelFrame().intensities != decoder_.getVoxelFrame().intensities)
      throw std::runtime_error("it was not decoded to what was encoded");
    const io::FrameStatistics& statistics = encoder_.getStatistics();
    ++report_.frames;
    report_.points += preprocessing.points - preprocessing.points_not_finite;
    report_.encoded_points += statistics.voxelization.points_used;
    report_.saturated_voxels += statistics.voxelization.intensities_out_of_range;
    report_.voxels += decoded_->size();
    report_.kept_voxels += denoised_.size();
    report_.bytes += statistics.coding.bytes;
  }

  const IntensityCloud&
  decoded() const
  {
    return *decoded_;
  }

  const IntensityCloud&
  denoised() const
  {
    return denoised_;
  }

private:
  static void
  check(const io::CompressionStatus& status, const std::string& action)
  {
    if (!status.ok())
      throw std::runtime_error(action + " failed: " + status.message());
  }

  Preprocessing preprocess_;
  Compression encoder_;
  Compression decoder_;
  float threshold_;
  StreamReport& report_;
  const IntensityCloud::Ptr preprocessed_{new IntensityCloud};
  IntensityCloud::Ptr decoded_{new IntensityCloud};
  IntensityCloud denoised_;
};

/** \brief Writes the clouds of a stream into folders of its own, for pcl_viewer. */
class CloudWriter {
public:
  /** \brief Makes the folders, and empties them of an earlier run's clouds.
   * \param[in] output_folder where; empty: nothing is written
   * \param[in] stream name of the stream
   */
  CloudWriter(const std::string& output_folder, const std::string& stream)
  {
    if (output_folder.empty())
      return;
    folder_ = fs::path(output_folder) / stream;
    for (const char* kind : {"decoded", "denoised"}) {
      fs::create_directories(folder_ / kind);
      for (const fs::directory_entry& entry : fs::directory_iterator(folder_ / kind))
        if (entry.path().extension() == ".pcd")
          fs::remove(entry.path());
    }
  }

  /** \brief Writes a cloud, unless it holds no point, which PCD cannot say.
   * \return its path; empty if it was not written
   */
  std::string
  write(const char* kind, std::size_t index, const IntensityCloud& cloud) const
  {
    if (folder_.empty() || cloud.empty())
      return {};
    std::ostringstream name;
    name << std::setw(4) << std::setfill('0') << index << ".pcd";
    const std::string path = (folder_ / kind / name.str()).string();
    if (pcl::io::savePCDFileBinaryCompressed(path, cloud) != 0)
      throw std::runtime_error("cannot write '" + path + "'");
    return path;
  }

private:
  fs::path folder_;
};

/** \brief The first cloud of a sequence that can be read; it tells which fields there
 * are.
 * \throws std::runtime_error if there is none
 */
void
readFirst(measuring::CloudSequence& sequence, pcl::PCLPointCloud2& cloud)
{
  for (std::size_t index = 0; index + 1 < sequence.size(); ++index) {
    try {
      sequence.read(index, cloud);
      return;
    }
    catch (const std::runtime_error&) {
      // It is reported when its turn comes.
    }
  }
  sequence.read(sequence.size() - 1, cloud);
}

} // namespace

StreamReport
runStream(measuring::CloudSequence& sequence,
          const StreamOptions& options,
          const std::optional<io::BoundingBox>& crop_box)
{
  StreamReport report;
  report.name = sequence.name();
  pcl::PCLPointCloud2 cloud;
  readFirst(sequence, cloud);
  const Law law = resolveLaw(options.law, cloud);
  report.law = nameOf(law);
  Pipeline pipeline(options, law, sequence.sensorPose(), crop_box, report);
  const CloudWriter writer(options.output_folder, report.name);

  std::cerr << report.name << ": " << sequence.size() << " frames\n";
  boost::timer::progress_display progress(sequence.size(), std::cerr);
  for (std::size_t index = 0; index < sequence.size(); ++index, ++progress) {
    try {
      sequence.read(index, cloud);
      pipeline.run(cloud);
    }
    catch (const std::exception& error) {
      // The frames behind it are none the worse for it.
      std::cerr << "\npcl_ext_stream: " << report.name << ", frame " << index << ": "
                << error.what() << '\n';
      ++report.failed_frames;
      continue;
    }
    const std::string path = writer.write("decoded", index, pipeline.decoded());
    if (report.example_cloud.empty())
      report.example_cloud = path;
    writer.write("denoised", index, pipeline.denoised());
  }
  return report;
}

} // namespace tools
} // namespace pcl_ext
