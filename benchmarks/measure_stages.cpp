/** \file
 * What each stage takes, from the sensor's cloud to bytes and back: time, the time that
 * memory alone would take, instructions and misses. Prints the tables of
 * doc/benchmarks.md about them.
 */
#include "event_counter.h"
#include "measuring/command_line.h"
#include "measuring/machine.h"
#include "measuring/markdown_table.h"
#include "memory_bandwidth.h"
#include "sampled_room.h"
#include "stage_counts.h"

#include <boost/program_options.hpp>

#include <algorithm>
#include <cstddef>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::measuring;
namespace options = boost::program_options;

struct StageOptions {
  std::vector<std::string> recordings; // folders of PCD files
  std::vector<Variant> variants;
  std::size_t frames = 0; // of the robot cell
  std::size_t room_frames = 0;
  std::size_t fewest_points = 0; // of the sampled room
  std::size_t most_points = 0;
  std::size_t repetitions = 0;
  Workload workload;
  std::string callgrind_file; // empty: the processor counts
};

/** \brief Limits what takes fifty times as long under callgrind, which counts the same each
 * time. */
void
limitForCallgrind(StageOptions& stage_options)
{
  constexpr std::size_t most_frames = 10;
  constexpr std::size_t most_room_frames = 3;
  constexpr std::size_t most_room_points = 1000000;
  stage_options.frames = std::min(stage_options.frames, most_frames);
  stage_options.room_frames = std::min(stage_options.room_frames, most_room_frames);
  stage_options.most_points = std::min(stage_options.most_points, most_room_points);
  stage_options.repetitions = 1;
}

bool
parse(int argc, const char* const* argv, StageOptions& result)
{
  result.variants = {libraryVariants().front()};
  options::options_description description(
      "Measures each stage from the sensor's cloud to bytes and back, on the robot "
      "cell, recordings and the sampled room, and prints Markdown.\n"
      "Usage: measure_stages [options] [folder of PCD files ...]\n\nOptions");
  auto option = description.add_options();
  option("help,h", "print this and exit");
  option("recording", options::value(&result.recordings), "folders of PCD files");
  option("efforts",
         choiceOfSeveral("efforts", result.variants, variantChoices()),
         "efforts of the coder: fast balanced small published (default: fast)");
  option("frames,n",
         count("frames", result.frames, 1)->default_value(60),
         "frames of the robot cell");
  option("room-frames",
         count("room-frames", result.room_frames, 1)->default_value(5),
         "frames of the sampled room");
  option("fewest-points",
         count("fewest-points", result.fewest_points, 1)->default_value(1000000),
         "least number of points of the sampled room");
  option("most-points",
         count("most-points", result.most_points, 0)->default_value(10000000),
         "largest number of points of the sampled room; 0: no room");
  option("repetitions",
         count("repetitions", result.repetitions, 1)->default_value(3),
         "repetitions of each stream; the least time of each frame counts");
  option("callgrind-file",
         options::value(&result.callgrind_file),
         "file of --callgrind-out-file, if the program runs under valgrind "
         "--tool=callgrind --instr-atstart=no; then counts are printed, no times, of "
         "at most 10 frames, 3 of a room and 1,000,000 points");
  options::variables_map values;
  if (!parseCommandLine(argc, argv, description, "recording", values))
    return false;
  if (!result.callgrind_file.empty())
    limitForCallgrind(result);
  return true;
}

MarkdownTable::Row
headerOf(const std::vector<StageCounts>& stages, bool has_times)
{
  MarkdownTable::Row header{"stage", "points", "voxels"};
  if (has_times)
    header.insert(header.end(),
                  {"ms",
                   "ns a point",
                   "ns a voxel",
                   "MB read",
                   "MB written",
                   "limit by memory, ms",
                   "time to limit"});
  for (std::size_t i = 0; i < event_names.size(); ++i)
    if (!stages.front().events[i].empty())
      header.insert(header.end(),
                    {std::string(event_names[i]) + " a point", "a voxel"});
  return header;
}

MarkdownTable::Row
rowOf(const StageCounts& stage, const std::optional<MemoryBandwidth>& bandwidth)
{
  const double points = stage.points.mean();
  const double voxels = stage.voxels.mean();
  MarkdownTable::Row row{stage.name, formatted(points, 0), formatted(voxels, 0)};
  if (bandwidth) {
    const double ms = stage.milliseconds.median();
    const double limit_ms = 1e3 * (stage.bytes_read.mean() / bandwidth->read +
                                   stage.bytes_written.mean() / bandwidth->write);
    row.insert(row.end(),
               {formatted(ms, 3),
                formatted(1e6 * ms / points, 2),
                formatted(1e6 * ms / voxels, 2),
                formatted(stage.bytes_read.mean() / 1e6, 3),
                formatted(stage.bytes_written.mean() / 1e6, 3),
                formatted(limit_ms, 3),
                formatted(ms / limit_ms, 1) + "x"});
  }
  for (const Samples& events : stage.events)
    if (!events.empty())
      row.insert(row.end(),
                 {formatted(events.median() / points, 2),
                  formatted(events.median() / voxels, 2)});
  return row;
}

void
printStream(const InputStream& stream,
            const StageOptions& options,
            const std::optional<MemoryBandwidth>& bandwidth,
            EventCounter& counter)
{
  for (const Variant& variant : options.variants) {
    std::cerr << "measure_stages: " << stream.clouds->name() << ", " << variant.name
              << '\n';
    const std::vector<StageCounts> stages =
        countStages(stream, options.workload, variant, options.repetitions, counter);
    std::cout << (bandwidth ? "### Stages: " : "### Stages, counted: ")
              << stream.clouds->name() << ", " << stream.clouds->size()
              << " frames, 4 cm, " << variant.name << "\n\n";
    MarkdownTable table(headerOf(stages, bandwidth.has_value()));
    for (const StageCounts& stage : stages)
      table.addRow(rowOf(stage, bandwidth));
    table.print(std::cout);
    std::cout.flush();
  }
}

void
measureStages(const StageOptions& options)
{
  const std::unique_ptr<EventCounter> counter =
      options.callgrind_file.empty() ? makeHardwareCounter()
                                     : makeCallgrindCounter(options.callgrind_file);
  std::optional<MemoryBandwidth> bandwidth;
  if (counter->keepsTime()) {
    bandwidth = measureMemoryBandwidth();
    std::cout << "Memory, one thread, " << bandwidth_buffer_megabytes
              << " MB: " << formatted(bandwidth->read / 1e9, 1) << " GB/s read, "
              << formatted(bandwidth->write / 1e9, 1) << " GB/s written.\n";
  }
  std::cout << counter->description() << "\n\n";
  constexpr unsigned int cell_sensor = 1;
  printStream(
      openCellStream(cell_sensor, options.frames), options, bandwidth, *counter);
  for (const InputStream& stream : openRecordedStreams(options.recordings))
    printStream(stream, options, bandwidth, *counter);
  for (std::size_t points = options.fewest_points; points <= options.most_points;
       points *= 10)
    printStream(
        openRoomStream(points, options.room_frames), options, bandwidth, *counter);
}

} // namespace

int
main(int argc, char** argv)
{
  return runProgram("measure_stages", [argc, argv] {
    StageOptions options;
    if (!parse(argc, argv, options))
      return 0;
    printMachine(std::cout);
    measureStages(options);
    return 0;
  });
}
