/** \file
 * This library against pcl::io::OctreePointCloudCompression on the same clouds in the
 * same run: bytes and times of encoding and decoding.
 *
 * Both get the cropped clouds of the robot cell in the world frame. PCL's class runs in
 * voxel-grid mode, which keeps the occupied voxels and no intensity.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/filters/sensor_preprocessor.h>

#include <pcl/compression/octree_pointcloud_compression.h>
#include <pcl/io/impl/entropy_range_coder.hpp>
#include <pcl/io/impl/octree_pointcloud_compression.hpp>

#include <boost/program_options.hpp>

#include <cell/robot_cell.h>

#include <algorithm>
#include <chrono>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

namespace {

using PointT = pcl::PointXYZI;
using Cloud = pcl::PointCloud<PointT>;
using OurCompression = pcl_ext::io::OctreePointCloudIntensityCompression<PointT>;
using PclCompression = pcl::io::OctreePointCloudCompression<PointT>;

struct Options {
  unsigned int frames = 0;
  unsigned int sensor = 1;
  unsigned int repetitions = 0;
  double resolution = 0.0;
  unsigned int i_frame_rate = 30;
};

/** \brief Sums over the stream; of several repetitions the fastest. */
struct Cost {
  std::size_t voxels = 0;
  std::size_t bytes = 0;
  double encode_ms = 0.0;
  double decode_ms = 0.0;
};

std::vector<Cloud::ConstPtr>
captureClouds(const Options& options)
{
  pcl_ext::cell::RobotCell cell;
  pcl_ext::SensorPreprocessor<pcl_ext::CountIntensity> preprocessor(
      pcl_ext::CountIntensity(options.resolution));
  preprocessor.setSensorPose(cell.sensorPose(options.sensor));
  preprocessor.setCropBox(pcl_ext::cell::RobotCell::cropMin().cast<float>(),
                          pcl_ext::cell::RobotCell::cropMax().cast<float>());
  pcl_ext::cell::CellFrame frame;
  std::vector<Cloud::ConstPtr> clouds;
  for (unsigned int index = 0; index < options.frames; ++index) {
    cell.capture(options.sensor, index, frame);
    const Cloud::Ptr cloud(new Cloud);
    preprocessor.process(frame.cloud, *cloud);
    clouds.push_back(cloud);
  }
  return clouds;
}

double
millisecondsSince(std::chrono::steady_clock::time_point start)
{
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() -
                                                   start)
      .count();
}

template <typename CompressionT>
Cost
runOnce(CompressionT& encoder,
        CompressionT& decoder,
        const std::vector<Cloud::ConstPtr>& clouds)
{
  Cost cost;
  Cloud::Ptr decoded(new Cloud);
  for (const Cloud::ConstPtr& cloud : clouds) {
    std::stringstream stream;
    auto start = std::chrono::steady_clock::now();
    encoder.encodePointCloud(cloud, stream);
    cost.encode_ms += millisecondsSince(start);
    cost.bytes += static_cast<std::size_t>(stream.tellp());
    start = std::chrono::steady_clock::now();
    decoder.decodePointCloud(stream, decoded);
    cost.decode_ms += millisecondsSince(start);
    cost.voxels += decoded->size();
  }
  return cost;
}

void
keepFastest(Cost& fastest, const Cost& cost)
{
  const bool is_first = fastest.voxels == 0;
  fastest.voxels = cost.voxels;
  fastest.bytes = cost.bytes;
  fastest.encode_ms =
      is_first ? cost.encode_ms : std::min(fastest.encode_ms, cost.encode_ms);
  fastest.decode_ms =
      is_first ? cost.decode_ms : std::min(fastest.decode_ms, cost.decode_ms);
}

Cost
runPcl(const Options& options, const std::vector<Cloud::ConstPtr>& clouds)
{
  const auto make = [&options] {
    return PclCompression(pcl::io::MANUAL_CONFIGURATION,
                          false,
                          options.resolution,
                          options.resolution,
                          true,
                          options.i_frame_rate,
                          false);
  };
  PclCompression encoder = make();
  PclCompression decoder = make();
  return runOnce(encoder, decoder, clouds);
}

Cost
runOurs(const Options& options,
        pcl_ext::io::StreamFormat format,
        const std::vector<Cloud::ConstPtr>& clouds)
{
  pcl_ext::io::IntensityCompressionSettings settings;
  settings.resolution = options.resolution;
  settings.i_frame_rate = options.i_frame_rate;
  settings.format = format;
  settings.aggregation = pcl_ext::io::Aggregation::Sum; // the intensity is the count
  OurCompression encoder(settings);
  OurCompression decoder(settings);
  return runOnce(encoder, decoder, clouds);
}

void
printRow(const std::string& name, const Cost& cost, const Cost& pcl, std::size_t frames)
{
  const auto mean = [frames](double sum) { return sum / static_cast<double>(frames); };
  std::cout << std::left << std::setw(38) << name << std::right << std::fixed
            << std::setprecision(0) << std::setw(9)
            << mean(static_cast<double>(cost.voxels)) << std::setprecision(3)
            << std::setw(13)
            << static_cast<double>(cost.bytes) / static_cast<double>(cost.voxels)
            << std::setprecision(2) << std::setw(11) << mean(cost.encode_ms)
            << std::setw(11) << mean(cost.decode_ms) << std::setprecision(1)
            << std::setw(10) << pcl.encode_ms / cost.encode_ms << "x" << std::setw(10)
            << pcl.decode_ms / cost.decode_ms << "x\n";
}

Options
parseOptions(int argc, char** argv)
{
  namespace options = boost::program_options;
  Options result;
  options::options_description description("Options");
  auto option = description.add_options();
  option("frames", options::value(&result.frames)->default_value(300), "of the cell");
  option("sensor", options::value(&result.sensor)->default_value(1), "1 to 6");
  option("resolution", options::value(&result.resolution)->default_value(0.04), "m");
  option("repetitions",
         options::value(&result.repetitions)->default_value(3),
         "of the whole stream; the fastest counts");
  options::variables_map values;
  options::store(options::parse_command_line(argc, argv, description), values);
  options::notify(values);
  return result;
}

} // namespace

int
main(int argc, char** argv)
{
  try {
    const Options options = parseOptions(argc, argv);
    const std::vector<Cloud::ConstPtr> clouds = captureClouds(options);
    Cost pcl;
    Cost version1;
    Cost published;
    for (unsigned int i = 0; i < options.repetitions; ++i) {
      keepFastest(pcl, runPcl(options, clouds));
      keepFastest(version1,
                  runOurs(options, pcl_ext::io::StreamFormat::Version1, clouds));
      keepFastest(published,
                  runOurs(options, pcl_ext::io::StreamFormat::Published, clouds));
    }
    std::cout << std::left << std::setw(38) << "per frame" << std::right
              << "   voxels  bytes/voxel  encode ms  decode ms   encoding   decoding\n";
    printRow("PCL, voxel grid, no intensity", pcl, pcl, clouds.size());
    printRow("pcl_ext, version 1, with intensity", version1, pcl, clouds.size());
    printRow("pcl_ext, published, with intensity", published, pcl, clouds.size());
  }
  catch (const std::exception& error) {
    std::cerr << "compare_with_pcl: " << error.what() << '\n';
    return 1;
  }
}
