/** \file
 * Takes a stream of clouds through the whole pipeline and prints its size and times.
 */
#include "measuring/cloud_sequence.h"
#include "measuring/command_line.h"
#include "measuring/markdown_table.h"
#include "simulator/crop_box.h"
#include "stream_options.h"
#include "stream_run.h"

#include <algorithm>
#include <exception>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace {

using pcl_ext::io::BoundingBox;
using pcl_ext::measuring::CloudSequence;
using pcl_ext::measuring::formatted;
using pcl_ext::measuring::MarkdownTable;
using pcl_ext::tools::DenoisingReport;
using pcl_ext::tools::RemovedVoxels;
using pcl_ext::tools::StreamOptions;
using pcl_ext::tools::StreamReport;

void
printReports(const std::vector<StreamReport>& reports)
{
  MarkdownTable table({"stream",
                       "intensity",
                       "frames",
                       "points",
                       "encoded",
                       "voxels",
                       "saturated",
                       "bytes",
                       "bytes/voxel",
                       "ratio",
                       "preprocess ms",
                       "encode ms",
                       "decode ms",
                       "denoise ms"});
  for (const StreamReport& report : reports) {
    const double frames = static_cast<double>(report.frames);
    const auto mean = [frames](auto sum, int digits) {
      return formatted(static_cast<double>(sum) / frames, digits);
    };
    const double voxels = static_cast<double>(std::max<std::size_t>(report.voxels, 1));
    const double bytes = static_cast<double>(std::max<std::size_t>(report.bytes, 1));
    table.addRow(
        {report.name,
         report.law,
         std::to_string(report.frames),
         mean(report.points, 0),
         mean(report.encoded_points, 0),
         mean(report.voxels, 0),
         mean(report.saturated_voxels, 0),
         mean(report.bytes, 0),
         formatted(bytes / voxels, 3),
         formatted(16.0 * static_cast<double>(report.encoded_points) / bytes, 1),
         mean(report.preprocess_ms, 2),
         mean(report.encode_ms, 2),
         mean(report.decode_ms, 2),
         mean(report.denoising.ms, 2)});
  }
  std::cout << "\nMeans of a frame:\n";
  table.print(std::cout);
  std::cout
      << "points: finite ones. encoded: points in voxels; the others were cropped or "
         "are outside the grid.\nsaturated: voxels whose intensity is above the scale. "
         "ratio: 16 bytes for each encoded\npoint against the bytes. ms: processor "
         "time.\n";
}

std::string
percent(std::size_t part, std::size_t whole)
{
  if (whole == 0)
    return "-";
  return formatted(100.0 * static_cast<double>(part) / static_cast<double>(whole), 1) +
         " %";
}

/** \brief Adds what one way of denoising does to a stream. */
void
addDenoisingRow(const StreamReport& report,
                const std::string& method,
                const RemovedVoxels& removed,
                bool is_used,
                MarkdownTable& table)
{
  const DenoisingReport& denoising = report.denoising;
  const std::size_t surfaces = denoising.labelled_voxels - denoising.noise_voxels;
  table.addRow({report.name,
                method + (is_used ? " (denoised clouds)" : ""),
                percent(removed.all, report.voxels),
                percent(denoising.noise_voxels, denoising.labelled_voxels),
                percent(removed.noise, denoising.noise_voxels),
                percent(surfaces - removed.surfaces, surfaces)});
}

void
printDenoising(const std::vector<StreamReport>& reports)
{
  MarkdownTable table(
      {"stream", "denoising", "removed", "noise", "noise removed", "surfaces kept"});
  for (const StreamReport& report : reports) {
    const DenoisingReport& denoising = report.denoising;
    std::ostringstream threshold;
    threshold << "threshold " << denoising.threshold;
    addDenoisingRow(
        report, threshold.str(), denoising.by_threshold, !denoising.uses_filter, table);
    if (denoising.has_filter)
      addDenoisingRow(
          report, "outlier filter", denoising.by_filter, denoising.uses_filter, table);
  }
  std::cout << "\nDenoising, shares of the voxels:\n";
  table.print(std::cout);
  std::cout
      << "noise: voxels without a point of a surface, known in the robot cell.\n\n";
}

int
run(const StreamOptions& options)
{
  std::vector<std::unique_ptr<CloudSequence>> sequences;
  std::optional<BoundingBox> crop_box = options.crop_box;
  if (!options.inputs.empty())
    sequences = pcl_ext::measuring::openSequences(options.inputs, options.frames);
  else {
    sequences.push_back(pcl_ext::measuring::openCell(
        options.cell_sensor, options.frames, options.seed));
    if (!crop_box)
      crop_box = pcl_ext::cell::cropBox();
  }
  if (const auto status = pcl_ext::io::checkSettings(options.settings); !status.ok())
    throw std::invalid_argument(status.message());
  std::vector<StreamReport> reports;
  bool has_failed = false;
  for (const auto& sequence : sequences) {
    try {
      reports.push_back(pcl_ext::tools::runStream(*sequence, options, crop_box));
      has_failed |= reports.back().failed_frames > 0;
    }
    catch (const std::exception& error) {
      // The other streams may be valid.
      std::cerr << "\npcl_ext_stream: " << sequence->name() << ": " << error.what()
                << '\n';
      has_failed = true;
    }
  }
  reports.erase(std::remove_if(reports.begin(),
                               reports.end(),
                               [](const StreamReport& r) { return r.frames == 0; }),
                reports.end());
  if (reports.empty())
    return 1;
  printReports(reports);
  printDenoising(reports);
  for (const StreamReport& report : reports)
    if (!report.example_cloud.empty()) {
      std::cout << "Look at the clouds with: pcl_viewer " << report.example_cloud
                << '\n';
      break;
    }
  return has_failed ? 1 : 0;
}

} // namespace

int
main(int argc, char** argv)
{
  return pcl_ext::measuring::runProgram("pcl_ext_stream", [argc, argv] {
    const std::optional<StreamOptions> options =
        pcl_ext::tools::parseOptions(argc, argv);
    return options ? run(*options) : 0;
  });
}
