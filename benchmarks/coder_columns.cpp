/** \file
 * The tables with a column for each coder: recorded clouds, numbers of points, voxel
 * edges, threads.
 */
#include "comparison_tables.h"
#include "measuring/markdown_table.h"
#include "sampled_room.h"
#include "table_cells.h"

#include <functional>
#include <ostream>
#include <string>
#include <thread>
#include <vector>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief A table with a column for each coder. */
struct CoderTable {
  std::string title;
  std::function<std::string(const CoderFigures&, const Comparison&)> cell;
};

/** \brief Several tables with the same rows and columns. */
class CoderTables {
public:
  /** \param[in] first_columns names of the columns before the coders'
   * \param[in] tables what the coders' cells show
   */
  CoderTables(MarkdownTable::Row first_columns, std::vector<CoderTable> tables)
  : tables_(std::move(tables))
  {
    for (const auto& coder : makeAllCoders(Workload()))
      first_columns.push_back(coder->name());
    printed_.assign(tables_.size(), MarkdownTable(first_columns));
  }

  void
  addRow(const MarkdownTable::Row& first_cells, const Comparison& comparison)
  {
    for (std::size_t i = 0; i < tables_.size(); ++i) {
      MarkdownTable::Row row = first_cells;
      for (const CoderFigures& coder : comparison.coders)
        row.push_back(tables_[i].cell(coder, comparison));
      printed_[i].addRow(row);
    }
  }

  void
  print(const std::string& title, std::ostream& output) const
  {
    for (std::size_t i = 0; i < tables_.size(); ++i) {
      output << "### " << title << ": " << tables_[i].title << "\n\n";
      printed_[i].print(output);
    }
  }

private:
  std::vector<CoderTable> tables_;
  std::vector<MarkdownTable> printed_;
};

CoderTables
growthTables(const std::string& first_column)
{
  return {{first_column, "voxels"},
          {{"encode ms, median",
            [](const CoderFigures& coder, const Comparison&) {
              return formatted(coder.encode_ms.median(), 3);
            }},
           {"decode ms, median",
            [](const CoderFigures& coder, const Comparison&) {
              return formatted(coder.decode_ms.median(), 3);
            }},
           {"bytes a frame",
            [](const CoderFigures& coder, const Comparison&) {
              return formatted(coder.bytes.mean(), 0);
            }},
           {"bytes per voxel", [](const CoderFigures& coder, const Comparison& all) {
              return formatted(all.bytesPerVoxel(coder), 3);
            }}}};
}

CoderTables
recordedTables()
{
  return {{"stream", "frames", "points", "voxels"},
          {{"bytes a frame (against published)",
            [](const CoderFigures& coder, const Comparison& all) {
              const std::string change = againstPublished(coder, all);
              return formatted(coder.bytes.mean(), 0) +
                     (change.empty() ? "" : " (" + change + ")");
            }},
           {"encode ms, median (how much faster than PCL, voxel grid)",
            [](const CoderFigures& coder, const Comparison& all) {
              return timeAgainst(coder.encode_ms, pclOf(all).encode_ms);
            }},
           {"decode ms, median (how much faster than PCL, voxel grid)",
            [](const CoderFigures& coder, const Comparison& all) {
              return timeAgainst(coder.decode_ms, pclOf(all).decode_ms);
            }}}};
}

std::string
voxelsOf(const Comparison& comparison)
{
  return formatted(comparison.coders.front().decoded.mean(), 0);
}

Comparison
compareInRoom(const ComparisonOptions& options, double resolution, std::size_t points)
{
  ComparisonSettings settings;
  // Ten million points need too much memory for all coders at once.
  settings.take_turns = false;
  // Repeated only where a frame is so short that the first use of memory dominates.
  settings.repetitions = points <= 100000 ? options.repetitions : 1;
  return compareCoders(openRoomStream(points, options.growth_frames),
                       workloadAt(resolution, options.i_frame_rate),
                       makeAllCoders,
                       settings);
}

} // namespace

void
printRecorded(const ComparisonOptions& options, std::ostream& output)
{
  if (options.recordings.empty())
    return;
  ComparisonSettings settings;
  settings.repetitions = options.repetitions;
  CoderTables tables = recordedTables();
  for (const InputStream& stream : openRecordedStreams(options.recordings)) {
    const Comparison comparison = compareCoders(
        stream, workloadAt(0.04, options.i_frame_rate), makeAllCoders, settings);
    tables.addRow({stream.clouds->name(),
                   std::to_string(stream.clouds->size()),
                   formatted(comparison.coders.front().points.mean(), 0),
                   voxelsOf(comparison)},
                  comparison);
  }
  tables.print("Recorded clouds, 4 cm, count", output);
}

void
printGrowthWithPoints(const ComparisonOptions& options, std::ostream& output)
{
  CoderTables tables = growthTables("points");
  for (std::size_t points = options.fewest_points; points <= options.most_points;
       points *= 10) {
    const Comparison comparison = compareInRoom(options, 0.04, points);
    tables.addRow({formatted(static_cast<double>(points), 0), voxelsOf(comparison)},
                  comparison);
  }
  tables.print("From few points to many, sampled room, 4 cm, count", output);
}

void
printThreads(const ComparisonOptions& options, std::ostream& output)
{
  MarkdownTable::Row columns{"points", "voxels", "PCL, voxel grid"};
  std::vector<unsigned int> threads;
  for (unsigned int count = 1; count <= std::thread::hardware_concurrency();
       count *= 2) {
    threads.push_back(count);
    columns.push_back("pcl_ext, fast, threads: " + std::to_string(count));
  }
  const auto make_coders = [&threads](Workload workload) {
    StreamCoders coders;
    addPclVoxelGridCoder(workload, coders);
    for (const unsigned int count : threads) {
      workload.threads = count;
      addLibraryCoder(workload, libraryVariants().front(), coders);
    }
    return coders;
  };
  ComparisonSettings settings;
  settings.take_turns = false;
  settings.measures_wall_time = true;
  MarkdownTable table(columns);
  for (std::size_t points = 100000; points <= options.most_points; points *= 10) {
    const Comparison comparison =
        compareCoders(openRoomStream(points, options.growth_frames),
                      workloadAt(0.04, options.i_frame_rate),
                      make_coders,
                      settings);
    MarkdownTable::Row row{formatted(static_cast<double>(points), 0),
                           formatted(comparison.coders.back().decoded.mean(), 0)};
    for (const CoderFigures& coder : comparison.coders)
      row.push_back(timeAgainst(coder.encode_ms, comparison.coders.front().encode_ms));
    table.addRow(row);
  }
  output << "### Threads, sampled room, 4 cm, count: encode ms of wall-clock time, "
            "median (how much faster than PCL)\n\n";
  table.print(output);
}

void
printGrowthWithEdge(const ComparisonOptions& options, std::ostream& output)
{
  CoderTables tables = growthTables("voxel edge");
  for (const double centimetres : {50.0, 20.0, 10.0, 5.0, 4.0, 2.0, 1.0, 0.5}) {
    const Comparison comparison =
        compareInRoom(options, centimetres / 100.0, options.edge_points);
    tables.addRow({formatted(centimetres, centimetres < 1.0 ? 1 : 0) + " cm",
                   voxelsOf(comparison)},
                  comparison);
  }
  tables.print("From coarse voxels to fine, sampled room, " +
                   formatted(static_cast<double>(options.edge_points), 0) +
                   " points, count",
               output);
}

} // namespace measuring
} // namespace pcl_ext
