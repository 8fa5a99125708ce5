#include "stream_run.h"

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/point_types.h>

#include "measuring/samples.h"
#include "measuring/workload.h"

#include <pcl/common/common.h>
#include <pcl/common/io.h>
#include <pcl/io/pcd_io.h>

#include <boost/timer/progress_display.hpp>

#include <algorithm>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace pcl_ext {
namespace tools {

namespace {

namespace fs = std::filesystem;

using measuring::IntensityCloud;
using measuring::timeOf;

bool
hasField(const pcl::PCLPointCloud2& cloud, const std::string& name)
{
  return std::any_of(cloud.fields.begin(), cloud.fields.end(), [&](const auto& field) {
    return field.name == name;
  });
}

bool
hasColour(const pcl::PCLPointCloud2& cloud)
{
  return hasField(cloud, "rgb") || hasField(cloud, "rgba");
}

bool
codesColours(const StreamOptions& options)
{
  return options.settings.colour_bits > 0 &&
         options.settings.format == io::StreamFormat::Version1;
}

IntensityLaw
lawOf(const StreamOptions& options, const pcl::PCLPointCloud2& cloud)
{
  if (options.law)
    return *options.law;
  return hasField(cloud, "intensity") ? IntensityLaw::Native : IntensityLaw::Count;
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

bool
areSame(const io::VoxelFrame& first, const io::VoxelFrame& second)
{
  return first.grid == second.grid && first.keys == second.keys &&
         first.intensities == second.intensities &&
         first.colour_bits == second.colour_bits && first.colours == second.colours &&
         first.point_counts == second.point_counts;
}

/** \brief The stages of one stream.
 * \tparam PointT pcl::PointXYZI, or PointXYZRGBI for coloured clouds
 */
template <typename PointT>
class Pipeline {
public:
  using Cloud = pcl::PointCloud<PointT>;

  Pipeline(const StreamOptions& options,
           IntensityLaw law,
           const Eigen::Isometry3d& sensor_pose,
           const std::optional<io::BoundingBox>& crop_box,
           StreamReport& report)
  : preprocess_(measuring::makePreprocessing<pcl::PCLPointCloud2, PointT>(
        law, options.settings.resolution, options.sensor, sensor_pose, crop_box))
  , encoder_(settingsOf(options, law, crop_box))
  , decoder_(settingsOf(options, law, crop_box))
  , denoising_(options, law)
  , report_(report)
  {
    if (options.inputs.empty())
      truth_.emplace(options);
  }

  /** \brief Takes a cloud through all stages.
   * \param[in] index of the cloud in its sequence
   * \throws std::runtime_error if one of them fails, or what was decoded is not what
   * was encoded
   */
  void
  run(std::size_t index, const pcl::PCLPointCloud2& cloud)
  {
    PreprocessingStatistics preprocessing;
    report_.preprocess_ms +=
        timeOf([&] { preprocessing = preprocess_(cloud, *preprocessed_); });
    std::stringstream bytes;
    report_.encode_ms += timeOf(
        [&] { check(encoder_.encodePointCloud(preprocessed_, bytes), "encoding"); });
    report_.decode_ms +=
        timeOf([&] { check(decoder_.decodePointCloud(bytes, decoded_), "decoding"); });
    if (!areSame(encoder_.getVoxelFrame(), decoder_.getVoxelFrame()) ||
        decoded_->size() != encoder_.getVoxelFrame().pointCount())
      throw std::runtime_error("the decoded frame differs from the encoded one");
    denoise(index);
    const io::FrameStatistics& statistics = encoder_.getStatistics();
    ++report_.frames;
    report_.points += preprocessing.points - preprocessing.points_not_finite;
    report_.encoded_points += statistics.voxelization.points_used;
    report_.saturated_voxels += statistics.voxelization.intensities_out_of_range;
    report_.voxels += decoded_->size();
    report_.bytes += statistics.coding.bytes;
    report_.denoising = denoising_.report();
  }

  const Cloud&
  decoded() const
  {
    return *decoded_;
  }

  const Cloud&
  denoised() const
  {
    return denoised_;
  }

private:
  void
  denoise(std::size_t index)
  {
    intensities_.resize(decoded_->size());
    for (std::size_t i = 0; i < decoded_->size(); ++i)
      intensities_[i] = (*decoded_)[i].intensity;
    const io::VoxelFrame& frame = decoder_.getVoxelFrame();
    const std::vector<noise::VoxelTruth>* truth =
        truth_ ? truth_->of(index, frame) : nullptr;
    pcl::copyPointCloud(
        *decoded_, denoising_.voxelsToKeep(frame, intensities_, truth), denoised_);
  }

  static void
  check(const io::CompressionStatus& status, const std::string& action)
  {
    if (!status.ok())
      throw std::runtime_error(action + " failed: " + status.message());
  }

  measuring::Preprocessing<pcl::PCLPointCloud2, PointT> preprocess_;
  io::OctreePointCloudIntensityCompression<PointT> encoder_;
  io::OctreePointCloudIntensityCompression<PointT> decoder_;
  Denoising denoising_;
  std::optional<CellTruth> truth_; ///< only of the robot cell
  StreamReport& report_;
  const typename Cloud::Ptr preprocessed_{new Cloud};
  typename Cloud::Ptr decoded_{new Cloud};
  Cloud denoised_;
  std::vector<float> intensities_; ///< of the decoded points
};

constexpr const char* cloud_kinds[] = {"decoded", "denoised"};

/** \brief Writes the clouds of a stream into folders of its own, for pcl_viewer. They
 * replace those of an earlier run when the stream is complete; until then, and if it
 * fails, they are in folders beside these, which the destructor removes. */
class CloudWriter {
public:
  /** \param[in] output_folder where; empty: nothing is written
   * \param[in] stream name of the stream
   */
  CloudWriter(const std::string& output_folder, const std::string& stream)
  {
    if (output_folder.empty())
      return;
    folder_ = fs::path(output_folder) / stream;
    for (const char* kind : cloud_kinds) {
      fs::remove_all(unfinished(kind)); // of a run that was interrupted
      fs::create_directories(unfinished(kind));
    }
  }

  ~CloudWriter()
  {
    std::error_code ignored;
    if (folder_.empty())
      return;
    for (const char* kind : cloud_kinds)
      fs::remove_all(unfinished(kind), ignored);
    fs::remove(folder_, ignored); // only if it is empty
  }

  CloudWriter(const CloudWriter&) = delete;
  CloudWriter&
  operator=(const CloudWriter&) = delete;

  /** \brief Writes a cloud unless it is empty, which PCD cannot store. */
  template <typename PointT>
  void
  write(const char* kind, std::size_t index, const pcl::PointCloud<PointT>& cloud) const
  {
    if (folder_.empty() || cloud.empty())
      return;
    std::ostringstream name;
    name << std::setw(4) << std::setfill('0') << index << ".pcd";
    const std::string path = (unfinished(kind) / name.str()).string();
    if (pcl::io::savePCDFileBinaryCompressed(path, cloud) != 0)
      throw std::runtime_error("cannot write '" + path + "'");
  }

  /** \brief Replaces the clouds of an earlier run.
   * \return path of the last denoised cloud, or of a decoded one; empty if none was
   * written
   */
  std::string
  finish() const
  {
    std::string example;
    if (folder_.empty())
      return example;
    for (const char* kind : cloud_kinds) {
      fs::create_directories(folder_ / kind);
      // Files of other names are the user's.
      for (const fs::path& old : pcdFilesOf(folder_ / kind))
        fs::remove(old);
      std::vector<fs::path> clouds = pcdFilesOf(unfinished(kind));
      std::sort(clouds.begin(), clouds.end());
      for (const fs::path& cloud : clouds)
        fs::rename(cloud, folder_ / kind / cloud.filename());
      if (!clouds.empty())
        example = (folder_ / kind / clouds.back().filename()).string();
    }
    return example;
  }

private:
  fs::path
  unfinished(const std::string& kind) const
  {
    return folder_ / (kind + "_unfinished");
  }

  static std::vector<fs::path>
  pcdFilesOf(const fs::path& folder)
  {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
      if (entry.path().extension() == ".pcd")
        files.push_back(entry.path());
    return files;
  }

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

std::string
corner(const Eigen::Vector4f& point)
{
  std::ostringstream text;
  text << std::setprecision(3) << '(' << point.x() << ", " << point.y() << ", "
       << point.z() << ')';
  return text.str();
}

/** \brief \throws std::runtime_error that says where the points of a cloud are, none of
 * which is in the crop box */
[[noreturn]] void
throwNothingToEncode(const pcl::PCLPointCloud2& cloud,
                     const StreamOptions& options,
                     IntensityLaw law,
                     const Eigen::Isometry3d& sensor_pose)
{
  IntensityCloud points;
  measuring::makePreprocessing<pcl::PCLPointCloud2>(
      law, options.settings.resolution, options.sensor, sensor_pose, std::nullopt)(
      cloud, points);
  if (points.empty())
    throw std::runtime_error("no cloud has a point that is finite");
  Eigen::Vector4f min;
  Eigen::Vector4f max;
  pcl::getMinMax3D(points, min, max);
  throw std::runtime_error("no point is inside the crop box; the first cloud has its "
                           "points between " +
                           corner(min) + " and " + corner(max) +
                           " m: choose --crop to hold some of them");
}

/** \brief Takes all clouds of a stream through the stages.
 * \tparam PointT as of Pipeline
 * \param[out] report the sums
 */
template <typename PointT>
void
runFrames(measuring::CloudSequence& sequence,
          const StreamOptions& options,
          IntensityLaw law,
          const std::optional<io::BoundingBox>& crop_box,
          const CloudWriter& writer,
          StreamReport& report)
{
  Pipeline<PointT> pipeline(options, law, sequence.sensorPose(), crop_box, report);
  pcl::PCLPointCloud2 cloud;
  boost::timer::progress_display progress(sequence.size(), std::cerr);
  for (std::size_t index = 0; index < sequence.size(); ++index, ++progress) {
    try {
      sequence.read(index, cloud);
      pipeline.run(index, cloud);
    }
    catch (const std::exception& error) {
      // The next frames may be valid.
      std::cerr << "\npcl_ext_stream: " << report.name << ", frame " << index << ": "
                << error.what() << '\n';
      ++report.failed_frames;
      continue;
    }
    writer.write("decoded", index, pipeline.decoded());
    writer.write("denoised", index, pipeline.denoised());
  }
}

/** \brief What becomes of the colours of a stream, for the console. */
std::string
describeColours(const StreamOptions& options, bool has_colour)
{
  if (!has_colour)
    return {};
  return codesColours(options)
             ? ", colours of " + std::to_string(options.settings.colour_bits) + " bits"
             : ", whose colours are left out";
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
  const CloudWriter writer(options.output_folder, report.name);
  const bool has_colour = hasColour(cloud);
  std::cerr << report.name << ": " << sequence.size() << " frames"
            << describeColours(options, has_colour) << '\n';
  const auto run = has_colour && codesColours(options) ? runFrames<PointXYZRGBI>
                                                       : runFrames<pcl::PointXYZI>;
  run(sequence, options, law, crop_box, writer, report);
  if (report.frames > 0 && report.encoded_points == 0) {
    readFirst(sequence, cloud);
    throwNothingToEncode(cloud, options, law, sequence.sensorPose());
  }
  if (report.frames > 0)
    report.example_cloud = writer.finish();
  return report;
}

} // namespace tools
} // namespace pcl_ext
