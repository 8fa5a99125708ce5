/** \file
 * Writing and reading a recording of six sensors.
 */
#include <pcl_ext/recording/recording_reader.h>
#include <pcl_ext/recording/recording_writer.h>

#include "measuring/markdown_table.h"
#include "measuring/samples.h"
#include "meters/stream_load.h"
#include "simulator/robot_cell.h"
#include "tables/tables.h"

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <ostream>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

namespace {

constexpr const char* file = "measured.mcap";

void
require(const recording::RecordingStatus& status)
{
  if (!status.ok())
    throw std::runtime_error(status.message());
}

/** \brief Writes frames of all streams, again and again.
 * \param[out] end_ms time that the end of the recording takes
 * \return processor time of all frames, milliseconds
 */
double
record(const std::vector<SensorStream>& sources, std::size_t frames, double& end_ms)
{
  recording::RecordingWriter writer;
  require(writer.open(file));
  std::vector<std::size_t> streams(sources.size());
  for (std::size_t i = 0; i < sources.size(); ++i)
    require(writer.addStream({"/sensor_" + std::to_string(i + 1), "world", {}},
                             streams[i]));
  double milliseconds = 0.0;
  for (std::size_t frame = 0; frame < frames; ++frame)
    for (std::size_t i = 0; i < sources.size(); ++i) {
      const auto& bytes = sources[i].frames[frame % sources[i].frames.size()];
      const recording::Time time = std::chrono::milliseconds(50 * frame + i);
      milliseconds += timeOf([&] {
        require(writer.append(streams[i], time, bytes.data(), bytes.size()));
      });
    }
  end_ms = timeOf([&] { require(writer.finish()); });
  return milliseconds;
}

/** \brief Milliseconds to decode each of some frames at random. */
Samples
readAtRandom(recording::RecordingReader& reader)
{
  constexpr int accesses = 300;
  std::mt19937_64 random(1);
  Samples times;
  io::VoxelFrame voxels;
  for (int i = 0; i < accesses; ++i) {
    const std::size_t stream = random() % reader.streams().size();
    const std::size_t number = random() % reader.streams()[stream].frames;
    times.add(wallTimeOf([&] {
      recording::RecordedStreamDecoder decoder(reader, stream);
      if (!decoder.decode(number, voxels).ok())
        throw std::runtime_error("a frame cannot be decoded");
    }));
  }
  return times;
}

} // namespace

void
printRecording(const Options& options, std::ostream& output)
{
  const Variant& balanced = variantNamed("balanced");
  const std::vector<SensorStream> sources =
      encodeCell(options.frames, Workload(), balanced);
  const double seconds = 60.0 * options.minutes;
  const auto frames = static_cast<std::size_t>(seconds * cell::RobotCell::frame_rate);
  double end_ms = 0.0;
  const double append_ms = record(sources, frames, end_ms);
  recording::RecordingReader reader;
  const double open_ms = wallTimeOf([&] { require(reader.open(file)); });
  const Samples accesses = readAtRandom(reader);
  MarkdownTable table({"six sensors, 20 Hz, " + std::to_string(options.minutes) +
                           " minutes, " + balanced.name,
                       "measured"});
  const auto all_frames = static_cast<double>(frames * sources.size());
  const auto megabytes = static_cast<double>(std::filesystem::file_size(file)) / 1e6;
  table.addRow({"frames", formatted(all_frames, 0)});
  table.addRow({"MB", formatted(megabytes, 1)});
  table.addRow({"a core: recording", formatted(append_ms / seconds / 10.0, 2) + " %"});
  table.addRow({"end of the recording, ms", formatted(end_ms, 1)});
  table.addRow({"open, ms", formatted(open_ms, 1)});
  table.addRow({"decode any frame, median, ms", formatted(accesses.median(), 1)});
  table.addRow(
      {"decode any frame, slowest of " + std::to_string(accesses.count()) + ", ms",
       formatted(accesses.largest(), 1)});
  std::filesystem::remove(file);
  output << "### A recording\n\n";
  table.print(output);
}

} // namespace measuring
} // namespace pcl_ext
