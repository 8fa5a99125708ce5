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
#include <vector>

namespace {

using pcl_ext::io::BoundingBox;
using pcl_ext::measuring::CloudSequence;
using pcl_ext::measuring::formatted;
using pcl_ext::measuring::MarkdownTable;
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
                       "denoised",
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
         mean(report.kept_voxels, 0),
         mean(report.bytes, 0),
         formatted(bytes / voxels, 3),
         formatted(16.0 * static_cast<double>(report.encoded_points) / bytes, 1),
         mean(report.preprocess_ms, 2),
         mean(report.encode_ms, 2),
         mean(report.decode_ms, 2),
         mean(report.denoise_ms, 2)});
  }
  std::cout << "\nMeans of a frame:\n";
  table.print(std::cout);
  std::cout
      << "points: finite ones. encoded: points in voxels; the others were cropped or "
         "are outside the grid.\nsaturated: voxels whose intensity is above the "
         "scale. denoised: voxels that denoising keeps.\nratio: 16 bytes for each "
         "encoded point against the bytes. ms: processor time.\n";
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
