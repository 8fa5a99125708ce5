/** \file
 * How time and bytes grow with the number of points and with finer voxels.
 */
#include "coder_comparison.h"
#include "comparison_tables.h"
#include "measuring/markdown_table.h"
#include "sampled_room.h"

#include <ostream>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief Four tables, times and bytes, with a column for each coder. */
class GrowthTables {
public:
  /** \param[in] size name of the first column */
  GrowthTables(const std::string& size, const Workload& workload)
  {
    MarkdownTable::Row header = {size, "voxels"};
    for (const auto& coder : makeAllCoders(workload))
      header.push_back(coder->name());
    tables_.assign(4, MarkdownTable(header));
  }

  void
  add(const std::string& size, const Comparison& comparison)
  {
    const std::string voxels = formatted(comparison.coders.front().decoded.mean(), 0);
    std::vector<MarkdownTable::Row> rows(tables_.size(), {size, voxels});
    for (const CoderFigures& coder : comparison.coders) {
      rows[0].push_back(formatted(coder.encode_ms.median(), 3));
      rows[1].push_back(formatted(coder.decode_ms.median(), 3));
      rows[2].push_back(formatted(coder.bytes.mean(), 0));
      rows[3].push_back(formatted(comparison.bytesPerVoxel(coder), 3));
    }
    for (std::size_t i = 0; i < tables_.size(); ++i)
      tables_[i].addRow(rows[i]);
  }

  void
  print(const std::string& title, std::ostream& output) const
  {
    const std::vector<std::string> figures = {
        "encode ms, median", "decode ms, median", "bytes a frame", "bytes per voxel"};
    for (std::size_t i = 0; i < tables_.size(); ++i) {
      output << "### " << title << ": " << figures[i] << "\n\n";
      tables_[i].print(output);
    }
  }

private:
  std::vector<MarkdownTable> tables_;
};

Comparison
compareInRoom(const ComparisonOptions& options,
              const Workload& workload,
              std::size_t points)
{
  // Ten million points need too much memory for all coders at once.
  ComparisonSettings settings;
  settings.take_turns = false;
  // What is over soon would else be mostly the first use of memory.
  settings.repetitions = points <= 100000 ? options.repetitions : 1;
  return compareCoders(
      openRoomStream(points, options.growth_frames), workload, makeAllCoders, settings);
}

} // namespace

void
printGrowthWithPoints(const ComparisonOptions& options, std::ostream& output)
{
  Workload workload;
  workload.i_frame_rate = options.i_frame_rate;
  GrowthTables tables("points", workload);
  for (std::size_t points = options.fewest_points; points <= options.most_points;
       points *= 10)
    tables.add(formatted(static_cast<double>(points), 0),
               compareInRoom(options, workload, points));
  tables.print("From few points to many, sampled room, 4 cm, count", output);
}

void
printGrowthWithEdge(const ComparisonOptions& options, std::ostream& output)
{
  Workload workload;
  workload.i_frame_rate = options.i_frame_rate;
  GrowthTables tables("voxel edge", workload);
  for (const double centimetres : {50.0, 20.0, 10.0, 5.0, 4.0, 2.0, 1.0, 0.5}) {
    workload.resolution = centimetres / 100.0;
    tables.add(formatted(centimetres, centimetres < 1.0 ? 1 : 0) + " cm",
               compareInRoom(options, workload, options.edge_points));
  }
  tables.print("From coarse voxels to fine, sampled room, " +
                   formatted(static_cast<double>(options.edge_points), 0) +
                   " points, count",
               output);
}

} // namespace measuring
} // namespace pcl_ext
