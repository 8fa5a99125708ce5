/** \file
 * How time, memory and allocations grow with the points and with finer voxels: the
 * tables and, as a file, the report's results.
 */
#include "coders/stream_coder.h"
#include "measuring/markdown_table.h"
#include "measuring/result_file.h"
#include "meters/coder_growth.h"
#include "tables/table_cells.h"
#include "tables/tables.h"

#include <iostream>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace measuring {

namespace {

constexpr double usual_edge_cm = 4.0;
constexpr std::size_t fewest_points = 1000;

/** \brief Up to here times are so short that more frames are measured. */
constexpr std::size_t few_points = 10000;
constexpr std::size_t more_frames = 10;

/** \brief A coder to measure: the first of those that are added. */
struct GrowingCoder {
  const char* name;
  void (*add)(const Workload&, StreamCoders&);
};

constexpr GrowingCoder growing_coders[] = {{"fast", addLibraryCoders},
                                           {"PCL", addPclVoxelGridCoder}};

/** \brief 1,000, 3,000, 10,000, ... and the most. */
std::vector<std::size_t>
numbersOfPoints(std::size_t most)
{
  std::vector<std::size_t> numbers;
  for (std::size_t points = fewest_points; points < most; points *= 10)
    for (const std::size_t number : {points, 3 * points})
      if (number < most)
        numbers.push_back(number);
  numbers.push_back(most);
  return numbers;
}

void
addResults(const Subject& subject, const GrowthFigures& figures, ResultFile& results)
{
  results.add(subject, "voxels", static_cast<double>(figures.voxels));
  const auto addCalls = [&](const std::string& name, const CallFigures& calls) {
    results.add(subject, name + "_median_ms", calls.milliseconds, figures.frames);
    results.add(subject, name + "_megabytes", calls.megabytes);
    results.add(subject, name + "_allocations", static_cast<double>(calls.allocations));
  };
  addCalls("encode", figures.encode);
  addCalls("decode", figures.decode);
}

/** \brief A table with a row for each size and coder. */
class GrowthTable {
public:
  /** \param[in] experiment name in the file of results
   * \param[in] results null: no file
   */
  GrowthTable(const std::string& first_column,
              std::string experiment,
              ResultFile* results)
  : experiment_(std::move(experiment))
  , results_(results)
  , table_({first_column,
            "voxels",
            "coder",
            "encode ms",
            "ns a point",
            "decode ms",
            "ns a voxel",
            "memory to encode, MB",
            "bytes a point",
            "memory to decode, MB",
            "bytes a voxel",
            "allocations, encode",
            "decode"})
  {}

  /** \brief Measures all coders at one size. */
  void
  addSize(const std::string& first_cell, std::size_t points, double edge_cm)
  {
    GrowthStream stream;
    stream.workload = workloadAt(edge_cm / 100.0);
    stream.workload.i_frame_rate = growth_i_frame_rate;
    stream.points = points;
    stream.periods = growth_periods * (points <= few_points ? more_frames : 1);
    for (const GrowingCoder& coder : growing_coders) {
      std::cerr << "growth: " << coder.name << ", " << points << " points, " << edge_cm
                << " cm\n";
      const auto make = [&] {
        StreamCoders coders;
        coder.add(stream.workload, coders);
        return std::move(coders.front());
      };
      const GrowthFigures figures = measureCoder(coder.name, make, stream);
      addRow(first_cell, coder.name, points, figures);
      if (results_ != nullptr)
        addResults({experiment_ + std::to_string(points),
                    "room",
                    coder.name,
                    stream.workload.resolution},
                   figures,
                   *results_);
    }
  }

  void
  print(std::ostream& output) const
  {
    table_.print(output);
  }

private:
  void
  addRow(const std::string& first_cell,
         const std::string& coder,
         std::size_t points,
         const GrowthFigures& figures)
  {
    const CallFigures& encode = figures.encode;
    const CallFigures& decode = figures.decode;
    const auto points_in = static_cast<double>(points);
    const auto voxels = static_cast<double>(figures.voxels);
    table_.addRow({first_cell,
                   formatted(voxels, 0),
                   coder,
                   formatted(encode.milliseconds, 3),
                   formatted(1e6 * encode.milliseconds / points_in, 1),
                   formatted(decode.milliseconds, 3),
                   formatted(1e6 * decode.milliseconds / voxels, 1),
                   formatted(encode.megabytes, 1),
                   formatted(1e6 * encode.megabytes / points_in, 1),
                   formatted(decode.megabytes, 1),
                   formatted(1e6 * decode.megabytes / voxels, 1),
                   std::to_string(encode.allocations),
                   std::to_string(decode.allocations)});
  }

  std::string experiment_;
  ResultFile* results_;
  MarkdownTable table_;
};

} // namespace

void
printGrowth(const Options& options, std::ostream& output)
{
  std::optional<ResultFile> file;
  if (!options.results_file.empty())
    file.emplace(options.results_file);
  ResultFile* const results = file ? &*file : nullptr;
  GrowthTable points_table("points", "growth_points:", results);
  for (const std::size_t points : numbersOfPoints(options.most_points))
    points_table.addSize(
        formatted(static_cast<double>(points), 0), points, usual_edge_cm);
  output << "### Growth with the points, sampled room, 4 cm, count\n\n";
  points_table.print(output);
  GrowthTable edges_table("voxel edge", "growth_edges:", results);
  for (const double edge_cm : {50.0, 20.0, 10.0, 5.0, 4.0, 2.0, 1.0, 0.5})
    edges_table.addSize(formatted(edge_cm, edge_cm < 1.0 ? 1 : 0) + " cm",
                        options.edge_points,
                        edge_cm);
  output << "### Growth with finer voxels, sampled room, "
         << formatted(static_cast<double>(options.edge_points), 0)
         << " points, count\n\n";
  edges_table.print(output);
  if (file)
    file->close();
}

} // namespace measuring
} // namespace pcl_ext
