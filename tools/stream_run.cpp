#include "stream_run.h"

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "measuring/samples.h"
#include "measuring/workload.h"

#include <pcl/filters/passthrough.h>
#include <pcl/io/pcd_io.h>

#include <boost/timer/progress_display.hpp>

#include <algorithm>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace pcl_ext {
namespace tools {

namespace {

namespace fs = std::filesystem;

using measuring::IntensityCloud;
using measuring::timeOf;
using Compression = io::OctreePointCloudIntensityCompression<pcl::PointXYZI>;

IntensityLaw
lawOf(const StreamOptions& options, const pcl::PCLPointCloud2& cloud)
{
  if (options.law)
    return *options.law;
  const bool has_intensity =
      std::any_of(cloud.fields.begin(), cloud.fields.end(), [](const auto& field) {
        return field.name == "intensity";
      });
  return has_intensity ? IntensityLaw::Native : IntensityLaw::Count;
}

/** \brief Thresholds of the paper's Figure 11. None for native intensities, which do
 * not depend on the number of points. */
float
defaultThreshold(IntensityLaw law)
{
  if (law == IntensityLaw::Native)
    return 0.0f;
  return needsSensor(law) ? 64.0f : 2.0f;
}

io::IntensityCompressionSettings
settingsOf(const StreamOptions& options,
           IntensityLaw law,
           const std::optional<io::BoundingBox>& crop_box)
{
  io::IntensityCompressionSettings settings = options.settings;
  settings.bounding_box = crop_box;
  return measuring::compressionSettings(law, options.sensor, settings);
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

/** \brief The stages of one stream. */
class Pipeline {
public:
  Pipeline(const StreamOptions& options,
           IntensityLaw law,
           const Eigen::Isometry3d& sensor_pose,
           const std::optional<io::BoundingBox>& crop_box,
           StreamReport& report)
  : preprocess_(measuring::makePreprocessing<pcl::PCLPointCloud2>(
        law, options.settings.resolution, options.sensor, sensor_pose, crop_box))
  , encoder_(settingsOf(options, law, crop_box))
  , decoder_(settingsOf(options, law, crop_box))
  , threshold_(options.threshold.value_or(defaultThreshold(law)))
  , report_(report)
  {}

  /** \brief Takes a cloud through all stages.
   * \throws std::runtime_error if one of them fails, or what was decoded is not what
   * was encoded
   */
  void
  run(const pcl::PCLPointCloud2& cloud)
  {
    PreprocessingStatistics preprocessing;
    report_.preprocess_ms +=
        timeOf([&] { preprocessing = preprocess_(cloud, *preprocessed_); });
    std::stringstream bytes;
    report_.encode_ms += timeOf(
        [&] { check(encoder_.encodePointCloud(preprocessed_, bytes), "encoding"); });
    report_.decode_ms +=
        timeOf([&] { check(decoder_.decodePointCloud(bytes, decoded_), "decoding"); });
    report_.denoise_ms += timeOf([&] { denoise(decoded_, threshold_, denoised_); });
    if (encoder_.getVoxelFrame().keys != decoder_.getVoxelFrame().keys ||
        encoder_.getVoxelFrame().intensities != decoder_.getVoxelFrame().intensities)
      throw std::runtime_error("the decoded frame differs from the encoded one");
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

  measuring::Preprocessing<pcl::PCLPointCloud2> preprocess_;
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
  /** \brief Makes the folders and removes the clouds of an earlier run.
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

  /** \brief Writes a cloud unless it is empty, which PCD cannot store.
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

/** \brief Reads the first cloud of a sequence that can be read; it has the fields of
 * all.
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
      // It is reported when it is processed.
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
  const IntensityLaw law = lawOf(options, cloud);
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
      // The next frames may be valid.
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
