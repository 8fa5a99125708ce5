/** \file
 * How time, memory and allocations grow with the points and with finer voxels. Prints the
 * tables of doc/benchmarks.md about it, and writes the report's results.
 */
#include "growth.h"
#include "measuring/command_line.h"
#include "measuring/machine.h"
#include "measuring/markdown_table.h"
#include "measuring/result_file.h"
#include "pcl_compression.h"
#include "table_cells.h"

#include <boost/program_options.hpp>

#include <array>
#include <cstddef>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::measuring;
namespace options = boost::program_options;

constexpr std::array<double, 8> edges_cm = {50.0, 20.0, 10.0, 5.0, 4.0, 2.0, 1.0, 0.5};
constexpr double usual_edge_cm = 4.0;
constexpr std::size_t fewest_points = 1000;

/** \brief Up to here times are so short that more frames are measured. */
constexpr std::size_t few_points = 10000;
constexpr std::size_t more_frames = 10;

struct GrowthOptions {
  std::size_t most_points = 0;
  std::size_t edge_points = 0; // while the voxel edge changes
  unsigned int i_frame_rate = 0;
  std::size_t periods = 0;
  std::string results_file; // empty: none
};

/** \brief A coder to measure: the first of those that are added. */
struct GrowingCoder {
  const char* name;
  void (*add)(const Workload&, StreamCoders&);
};

constexpr std::array<GrowingCoder, 2> growing_coders = {
    {{"fast", addLibraryCoders}, {"PCL", addPclVoxelGridCoder}}};

bool
parse(int argc, const char* const* argv, GrowthOptions& result)
{
  options::options_description description(
      "Measures effort fast and PCL's class in voxel-grid mode on the sampled room, "
      "from 1,000 points to many and from coarse voxels to fine, and prints Markdown.\n"
      "Usage: measure_growth [options]\n\nOptions");
  auto option = description.add_options();
  option("help,h", "print this and exit");
  option(
      "most-points",
      count("most-points", result.most_points, fewest_points)->default_value(50000000),
      "largest number of points; 50 millions take 10 GB of memory");
  option("edge-points",
         count("edge-points", result.edge_points, 1)->default_value(1000000),
         "points while the voxel edge changes");
  option("i-frame-rate",
         count("i-frame-rate", result.i_frame_rate, 1)->default_value(4),
         "frames from one I-frame to the next");
  option("periods",
         count("periods", result.periods, warm_up_periods + 1)->default_value(4),
         "I-frame periods of each stream, ten times as many up to 10,000 points; times "
         "are of all but the first two");
  option("results", options::value(&result.results_file), "CSV file to write");
  options::variables_map values;
  return parseCommandLine(argc, argv, description, "", values);
}

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

/** \brief Measures and collects results. */
class GrowthTables {
public:
  explicit GrowthTables(const GrowthOptions& options) : options_(options)
  {
    if (!options.results_file.empty())
      results_.emplace(options.results_file);
  }

  /** \brief Measures all coders at one size and adds a row for each.
   * \param[in] experiment name in the file of results
   * \param[in] first_cell of the rows
   */
  void
  addSize(const std::string& experiment,
          const std::string& first_cell,
          std::size_t points,
          double edge_cm,
          MarkdownTable& table)
  {
    GrowthStream stream;
    stream.workload = workloadAt(edge_cm / 100.0, options_.i_frame_rate);
    stream.points = points;
    stream.periods = options_.periods * (points <= few_points ? more_frames : 1);
    for (const GrowingCoder& coder : growing_coders) {
      std::cerr << "measure_growth: " << coder.name << ", " << points << " points, "
                << edge_cm << " cm\n";
      const auto make = [&] {
        StreamCoders coders;
        coder.add(stream.workload, coders);
        return std::move(coders.front());
      };
      const GrowthFigures figures = measureCoder(coder.name, make, stream);
      addRow(first_cell, coder.name, points, figures, table);
      if (results_)
        addResults({experiment, "room", coder.name, stream.workload.resolution},
                   figures);
    }
  }

  /** \brief Ends the file of results.
   * \throws std::runtime_error if not all of it could be written
   */
  void
  close()
  {
    if (results_)
      results_->close();
  }

private:
  static void
  addRow(const std::string& first_cell,
         const std::string& coder,
         std::size_t points,
         const GrowthFigures& figures,
         MarkdownTable& table)
  {
    const CallFigures& encode = figures.encode;
    const CallFigures& decode = figures.decode;
    const auto points_in = static_cast<double>(points);
    const auto voxels = static_cast<double>(figures.voxels);
    table.addRow({first_cell,
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

  void
  addResults(const Subject& subject, const GrowthFigures& figures)
  {
    const auto voxels = static_cast<double>(figures.voxels);
    results_->add(subject, "voxels", voxels);
    const auto addCalls = [&](const std::string& name, const CallFigures& calls) {
      results_->add(subject, name + "_median_ms", calls.milliseconds, figures.frames);
      results_->add(subject, name + "_megabytes", calls.megabytes);
      results_->add(
          subject, name + "_allocations", static_cast<double>(calls.allocations));
    };
    addCalls("encode", figures.encode);
    addCalls("decode", figures.decode);
  }

  const GrowthOptions& options_;
  std::optional<ResultFile> results_;
};

MarkdownTable
tableWith(const std::string& first_column)
{
  return MarkdownTable({first_column,
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
                        "decode"});
}

void
measureGrowth(const GrowthOptions& options)
{
  GrowthTables tables(options);
  MarkdownTable points_table = tableWith("points");
  for (const std::size_t points : numbersOfPoints(options.most_points))
    tables.addSize("growth_points:" + std::to_string(points),
                   formatted(static_cast<double>(points), 0),
                   points,
                   usual_edge_cm,
                   points_table);
  std::cout << "### Growth with the points, sampled room, 4 cm, count\n\n";
  points_table.print(std::cout);
  MarkdownTable edges_table = tableWith("voxel edge");
  for (const double edge_cm : edges_cm)
    tables.addSize("growth_edges:" + std::to_string(options.edge_points),
                   formatted(edge_cm, edge_cm < 1.0 ? 1 : 0) + " cm",
                   options.edge_points,
                   edge_cm,
                   edges_table);
  std::cout << "### Growth with finer voxels, sampled room, "
            << formatted(static_cast<double>(options.edge_points), 0)
            << " points, count\n\n";
  edges_table.print(std::cout);
  tables.close();
}

} // namespace

int
main(int argc, char** argv)
{
  return runProgram("measure_growth", [argc, argv] {
    GrowthOptions options;
    if (!parse(argc, argv, options))
      return 0;
    printMachine(std::cout);
    measureGrowth(options);
    return 0;
  });
}
