/** \file
 * Measures recording and reading of a recording of six sensors. Prints the table of
 * doc/benchmarks.md about it.
 */
#include <pcl_ext/compression/frame_encoder.h>
#include <pcl_ext/recording/recording_reader.h>
#include <pcl_ext/recording/recording_writer.h>

#include "measuring/command_line.h"
#include "measuring/machine.h"
#include "measuring/markdown_table.h"
#include "measuring/samples.h"
#include "simulator/cell_voxelizer.h"
#include "simulator/robot_cell.h"

#include <boost/program_options.hpp>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::measuring;
namespace options = boost::program_options;
namespace recording = pcl_ext::recording;

constexpr std::size_t sensors = 6;
constexpr double frames_per_second = 20;

struct Options {
  unsigned int minutes = 10;
  unsigned int frames = 100;   // of each sensor, which are repeated
  unsigned int accesses = 300; // at random
  pcl_ext::io::Effort effort = pcl_ext::io::Effort::Balanced;
  std::string file;
};

/** \brief What is measured, milliseconds. */
struct Times {
  double encode = 0; // of all frames
  double append = 0;
  double finish = 0;
  double open = 0;
  std::vector<double> accesses; // to a frame, sorted
};

void
require(const recording::RecordingStatus& status)
{
  if (!status.ok())
    throw std::runtime_error(status.message());
}

bool
parse(int argc, const char* const* argv, Options& result)
{
  using pcl_ext::io::Effort;
  options::options_description description(
      "Records six sensors of the robot cell at 20 Hz, reads frames in any order, and "
      "prints Markdown.\nUsage: measure_recordings [options]\n\nOptions");
  auto option = description.add_options();
  option("help,h", "print this and exit");
  option("minutes",
         count("minutes", result.minutes, 1)->default_value(10),
         "length of the recording");
  option("frames,n",
         count("frames", result.frames, 1)->default_value(100),
         "frames of each sensor, which are encoded again and again");
  option("accesses",
         count("accesses", result.accesses, 1)->default_value(300),
         "frames to decode in any order");
  option("effort",
         choice<Effort>("effort",
                        result.effort,
                        {{"fast", Effort::Fast},
                         {"balanced", Effort::Balanced},
                         {"small", Effort::Small}})
             ->default_value("balanced"),
         "fast, balanced or small");
  option("file",
         options::value(&result.file)->default_value("measured.mcap"),
         "the recording, which is removed afterwards");
  options::variables_map values;
  return parseCommandLine(argc, argv, description, "", values);
}

std::vector<pcl_ext::io::VoxelFrame>
voxelsOf(pcl_ext::cell::RobotCell& cell, unsigned int sensor, unsigned int count)
{
  const pcl_ext::CountIntensity model(0.04);
  pcl_ext::noise::CellVoxelizer<pcl_ext::CountIntensity> voxelizer(
      model, cell.sensorPose(sensor));
  std::vector<pcl_ext::io::VoxelFrame> frames(count);
  pcl_ext::cell::CellFrame captured;
  for (unsigned int i = 0; i < count; ++i) {
    cell.capture(sensor, i, captured);
    voxelizer.voxelize(captured.cloud, frames[i]);
  }
  return frames;
}

/** \brief Encodes and records all streams.
 * \return number of frames of each sensor
 */
std::size_t
recordSensors(const Options& options, Times& times)
{
  pcl_ext::cell::RobotCell cell(1);
  std::vector<std::vector<pcl_ext::io::VoxelFrame>> voxels;
  std::vector<pcl_ext::io::FrameEncoder> encoders;
  recording::RecordingWriter writer;
  require(writer.open(options.file));
  std::vector<std::size_t> streams(sensors);
  for (std::size_t i = 0; i < sensors; ++i) {
    voxels.push_back(voxelsOf(cell, static_cast<unsigned int>(i + 1), options.frames));
    encoders.emplace_back(pcl_ext::io::StreamFormat::Version1, 30u, options.effort);
    require(writer.addStream({"/sensor_" + std::to_string(i + 1), "world", {}},
                             streams[i]));
  }
  const auto frames =
      static_cast<std::size_t>(60 * options.minutes * frames_per_second);
  std::vector<std::uint8_t> bytes;
  for (std::size_t frame = 0; frame < frames; ++frame)
    for (std::size_t i = 0; i < sensors; ++i) {
      // Forwards and backwards, so that nothing jumps.
      const std::size_t phase = frame % (2 * options.frames);
      const std::size_t index = std::min(phase, 2 * options.frames - 1 - phase);
      times.encode +=
          timeOf([&] { encoders[i].encode(voxels[i][index], std::nullopt, bytes); });
      const recording::Time time = std::chrono::milliseconds(50 * frame + i);
      times.append += timeOf([&] {
        require(writer.append(streams[i], time, bytes.data(), bytes.size()));
      });
    }
  times.finish = timeOf([&] { require(writer.finish()); });
  return frames;
}

void
readAtRandom(const Options& options, Times& times)
{
  recording::RecordingReader reader;
  times.open = wallTimeOf([&] { require(reader.open(options.file)); });
  std::mt19937_64 random(1);
  pcl_ext::io::VoxelFrame voxels;
  for (unsigned int i = 0; i < options.accesses; ++i) {
    const std::size_t stream = random() % reader.streams().size();
    const std::size_t number = random() % reader.streams()[stream].frames;
    times.accesses.push_back(wallTimeOf([&] {
      recording::RecordedStreamDecoder decoder(reader, stream);
      if (!decoder.decode(number, voxels).ok())
        throw std::runtime_error("a frame cannot be decoded");
    }));
  }
  std::sort(times.accesses.begin(), times.accesses.end());
}

void
print(const Options& options,
      std::size_t frames,
      std::uintmax_t bytes,
      const Times& times)
{
  printMachine(std::cout);
  const double seconds = 60.0 * options.minutes;
  const auto percentOfACore = [seconds](double ms) {
    return formatted(ms / seconds / 10.0, 2) + " %";
  };
  MarkdownTable table(
      {"six sensors, 20 Hz, " + std::to_string(options.minutes) + " minutes",
       "measured"});
  table.addRow({"frames", formatted(static_cast<double>(frames * sensors), 0)});
  table.addRow({"MB", formatted(static_cast<double>(bytes) / 1e6, 1)});
  table.addRow({"a core: encoding", percentOfACore(times.encode)});
  table.addRow({"a core: recording besides", percentOfACore(times.append)});
  table.addRow({"end of the recording, ms", formatted(times.finish, 1)});
  table.addRow({"open, ms", formatted(times.open, 1)});
  table.addRow({"decode any frame, median, ms",
                formatted(times.accesses[times.accesses.size() / 2], 1)});
  table.addRow(
      {"decode any frame, slowest of " + std::to_string(times.accesses.size()) + ", ms",
       formatted(times.accesses.back(), 1)});
  std::cout << '\n';
  table.print(std::cout);
}

} // namespace

int
main(int argc, char** argv)
{
  return runProgram("measure_recordings", [argc, argv] {
    Options options;
    if (!parse(argc, argv, options))
      return 0;
    Times times;
    const std::size_t frames = recordSensors(options, times);
    readAtRandom(options, times);
    const std::uintmax_t bytes = std::filesystem::file_size(options.file);
    std::filesystem::remove(options.file);
    print(options, frames, bytes, times);
    return 0;
  });
}
