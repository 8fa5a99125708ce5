/** \file
 * What each stage takes, from the sensor's cloud to bytes and back.
 */
#include "inputs/sampled_room.h"
#include "measuring/markdown_table.h"
#include "meters/stage_times.h"
#include "tables/tables.h"

#include <ostream>
#include <string>

namespace pcl_ext {
namespace measuring {

namespace {

void
printStream(const InputStream& stream, const Options& options, std::ostream& output)
{
  for (const std::string& effort : options.efforts) {
    output << "### Stages: " << stream.clouds->name() << ", " << stream.clouds->size()
           << " frames, 4 cm, " << effort << "\n\n";
    MarkdownTable table(
        {"stage", "points", "voxels", "ms", "ns a point", "ns a voxel"});
    for (const StageTimes& stage :
         timeStages(stream, Workload(), variantNamed(effort), options.repetitions)) {
      const double ms = stage.milliseconds.median();
      table.addRow({stage.name,
                    formatted(stage.points.mean(), 0),
                    formatted(stage.voxels.mean(), 0),
                    formatted(ms, 3),
                    formatted(1e6 * ms / stage.points.mean(), 2),
                    formatted(1e6 * ms / stage.voxels.mean(), 2)});
    }
    table.print(output);
  }
}

} // namespace

void
printStages(const Options& options, std::ostream& output)
{
  printStream(openCellStream(first_sensor, options.frames), options, output);
  for (const InputStream& stream : openRecordedStreams(options.recordings))
    printStream(stream, options, output);
  for (std::size_t points = 1000000; points <= options.most_points; points *= 10)
    printStream(openRoomStream(points, room_frames), options, output);
}

} // namespace measuring
} // namespace pcl_ext
