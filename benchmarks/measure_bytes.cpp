/** \file
 * Prints where the bytes of a stream go, and the entropy of its decisions by their
 * contexts: doc/benchmarks.md, "Where the bytes go".
 */
#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/intensity/intensity_law.h>
#include <pcl_ext/point_intensity.h>
#include <pcl_ext/point_types.h>

#include "measuring/command_line.h"
#include "measuring/markdown_table.h"
#include "measuring/workload.h"
#include "payload_meter.h"

#include <boost/program_options.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::measuring;
namespace options = boost::program_options;

struct ByteOptions {
  std::vector<std::string> recordings; ///< folders of PCD files; empty: the robot cell
  std::size_t frames = 0;
  unsigned int sensor = 0; ///< of the robot cell, 1..6
  Workload workload;
  std::vector<Variant> efforts;
  bool has_colours = false;
  bool keep_point_counts = false;
};

/** \brief Calls a function with each frame of a stream and the encoder's figures. */
template <typename PointT, typename FunctionT>
void
encodeStream(const InputStream& stream,
             const ByteOptions& options,
             const Variant& effort,
             const FunctionT& use)
{
  const Workload& workload = options.workload;
  io::IntensityCompressionSettings settings = compressionSettings(workload, effort);
  settings.keep_point_counts = options.keep_point_counts;
  io::CloudEncoder encoder(settings, IntensityUnit::Native);
  pcl::PCLPointCloud2 cloud;
  pcl::PointCloud<PointT> points;
  io::VoxelFrame voxels;
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < stream.clouds->size(); ++i) {
    stream.clouds->read(i, cloud);
    const Eigen::Isometry3d pose = stream.clouds->sensorPoseAt(i);
    makePreprocessing<pcl::PCLPointCloud2, PointT>(workload.law,
                                                   workload.resolution,
                                                   runtimeSensor(KinectV2()),
                                                   pose,
                                                   stream.crop_box)(cloud, points);
    throwUnlessOk(
        encoder.voxelize(pointViewWithIntensities(points), WorldPose(pose), voxels));
    throwUnlessOk(encoder.encode(voxels, std::nullopt, bytes));
    use(bytes, encoder.statistics().coding);
  }
}

void
add(const io::CodedFrameStatistics& frame, io::CodedFrameStatistics& sum)
{
  sum.voxels += frame.voxels;
  sum.bytes += frame.bytes;
  sum.header_bytes += frame.header_bytes;
  sum.occupancy_bytes += frame.occupancy_bytes;
  sum.intensity_bytes += frame.intensity_bytes;
  sum.attribute_bytes += frame.attribute_bytes;
}

/** \brief A row of the table: bits or numbers as bytes or numbers a voxel. */
MarkdownTable::Row
rowOf(const std::string& name, const Figures& figures, std::size_t voxels)
{
  MarkdownTable::Row row{name};
  for (std::size_t figure = 0; figure < figure_count; ++figure)
    row.push_back(formatted(figures[figure] / (figure == decisions ? 1.0 : 8.0) /
                                static_cast<double>(voxels),
                            4));
  return row;
}

/** \brief Adds the parts of the payloads.
 * \param[in] parts as they were decoded
 * \param[in] bytes of the payloads without supplements, counted by the encoder
 * \throws std::runtime_error if those are not the parts' bytes
 */
void
addParts(const std::array<Figures, part_count>& parts,
         std::size_t bytes,
         const io::CodedFrameStatistics& sum,
         MarkdownTable& table)
{
  const std::array<const char*, part_count> names = {"use of the history",
                                                     "tracked voxels",
                                                     "tracked blocks with new voxels",
                                                     "new voxels in tracked blocks",
                                                     "nodes of new blocks",
                                                     "numbers",
                                                     "residuals",
                                                     "numbers of points"};
  Figures all{};
  for (std::size_t part = 0; part < part_count; ++part) {
    for (std::size_t figure = 0; figure < figure_count; ++figure)
      all[figure] += parts[part][figure];
    if (parts[part][ideal] > 0.0)
      table.addRow(rowOf(std::string("- ") + names[part], parts[part], sum.voxels));
  }
  table.addRow(rowOf("- all of these", all, sum.voxels));
  for (const double bits : {all[coded], all[ideal]})
    if (std::abs(bits / 8.0 - static_cast<double>(bytes)) >
        0.01 * static_cast<double>(bytes))
      throw std::runtime_error("the decisions take " + formatted(bits / 8.0, 0) +
                               " bytes; the encoder counts " + std::to_string(bytes));
}

template <typename PointT>
void
printTable(const InputStream& stream, const ByteOptions& options, const Variant& effort)
{
  const bool is_small = effort.effort == io::Effort::Small;
  const bool has_decisions = is_small || effort.effort == io::Effort::Balanced;
  PayloadMeter<false> balanced;
  PayloadMeter<true> small;
  io::CodedFrameStatistics sum;
  std::size_t supplement_bytes = 0;
  encodeStream<PointT>(
      stream, options, effort, [&](const auto& bytes, const auto& figures) {
        add(figures, sum);
        if (has_decisions)
          supplement_bytes += is_small ? small.add(bytes) : balanced.add(bytes);
      });
  const std::size_t frames = stream.clouds->size();
  std::cout << "### Where the bytes go: " << stream.clouds->name() << ", "
            << formatted(100.0 * options.workload.resolution, 1) << " cm, "
            << nameOf(options.workload.law) << ", effort " << effort.name << ", "
            << frames << " frames, " << sum.voxels / frames << " voxels\n\n";
  MarkdownTable table({"bytes per voxel",
                       "coded",
                       "-log2 p",
                       "adaptive, first",
                       "best",
                       "joint",
                       "fixed, first",
                       "best",
                       "joint",
                       "decisions"});
  const auto add_bytes = [&](const char* name, std::size_t bytes) {
    MarkdownTable::Row row =
        rowOf(name, {8.0 * static_cast<double>(bytes)}, sum.voxels);
    std::fill(row.begin() + 2, row.end(), "");
    table.addRow(row);
  };
  add_bytes("header", sum.header_bytes);
  add_bytes("occupancy", sum.occupancy_bytes);
  add_bytes("intensity", sum.intensity_bytes);
  add_bytes("colours, numbers of points", sum.attribute_bytes);
  add_bytes("all", sum.bytes);
  if (has_decisions) {
    add_bytes("- supplement", supplement_bytes);
    addParts(is_small ? small.result() : balanced.result(),
             sum.bytes - sum.header_bytes - supplement_bytes,
             sum,
             table);
  }
  table.print(std::cout);
}

bool
parse(int argc, const char* const* argv, ByteOptions& result)
{
  Choices<Variant> efforts = variantChoices();
  efforts.pop_back(); // the published layout
  for (const auto& named : efforts)
    result.efforts.push_back(named.second);
  Choices<IntensityLaw> laws;
  for (const NamedIntensityLaw& named : intensity_laws)
    if (named.law != IntensityLaw::None) // its tables tell the bytes of intensities
      laws.emplace_back(named.name, named.law);
  options::options_description description(
      "Prints where the bytes of a stream go, and the entropy of its decisions by "
      "their "
      "contexts, as Markdown.\n"
      "Usage: measure_bytes [options] [folder of PCD files ...]\n\nOptions");
  auto option = description.add_options();
  option("help,h", "print this and exit");
  option("recording",
         options::value(&result.recordings),
         "folders of PCD files (default: the robot cell)");
  option("frames,n",
         count("frames", result.frames, 1)->default_value(60),
         "frames of each stream, at most");
  option("sensor",
         count("sensor", result.sensor, 1, 6)->default_value(1),
         "sensor of the robot cell, 1 to 6");
  option("resolution,r",
         number("resolution", result.workload.resolution, 1e-6, 1e6)
             ->default_value(0.04, "0.04"),
         "voxel edge, m");
  option("intensity,i",
         choice("intensity", result.workload.law, laws)->default_value("count"),
         "count, quadratic, linear or native");
  option("i-frame-rate",
         count("i-frame-rate", result.workload.i_frame_rate, 0)->default_value(30),
         "frames from one I-frame to the next");
  option("efforts",
         choiceOfSeveral("efforts", result.efforts, efforts),
         "fast balanced small (default: all)");
  option("colours",
         options::bool_switch(&result.has_colours),
         "code the colours, which the clouds must have");
  option("keep-point-counts",
         options::bool_switch(&result.keep_point_counts),
         "code the number of points of each voxel");
  options::variables_map values;
  return parseCommandLine(argc, argv, description, "recording", values);
}

} // namespace

int
main(int argc, char** argv)
{
  return runProgram("measure_bytes", [argc, argv] {
    ByteOptions options;
    if (!parse(argc, argv, options))
      return 0;
    std::vector<InputStream> streams;
    for (auto& clouds : openSequences(options.recordings, options.frames))
      streams.push_back({std::move(clouds), std::nullopt});
    if (options.recordings.empty())
      streams.push_back(openCellStream(options.sensor, options.frames));
    for (const InputStream& stream : streams)
      for (const Variant& effort : options.efforts)
        (options.has_colours ? printTable<PointXYZRGBI>
                             : printTable<pcl::PointXYZI>)(stream, options, effort);
    return 0;
  });
}
