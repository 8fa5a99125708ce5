/** \file
 * The main job of this project as one program: a stream of clouds through the whole
 * pipeline, and a table of what it cost.
 */
#include "measuring/cloud_sequence.h"
#include "simulator/crop_box.h"
#include "stream_options.h"
#include "stream_run.h"

#include <algorithm>
#include <exception>
#include <iomanip>
#include <iostream>
#include <memory>
#include <optional>
#include <vector>

namespace {

using pcl_ext::io::BoundingBox;
using pcl_ext::measuring::CloudSequence;
using pcl_ext::tools::StreamOptions;
using pcl_ext::tools::StreamReport;

void
printReports(const std::vector<StreamReport>& reports)
{
  std::size_t name_width = 8;
  for (const StreamReport& report : reports)
    name_width = std::max(name_width, report.name.size());
  std::cout << "\nPer frame:\n"
            << std::left << std::setw(static_cast<int>(name_width)) << "stream"
            << "  " << std::setw(9) << "intensity" << std::right << std::setw(8)
            << "frames" << std::setw(10) << "points" << std::setw(10) << "encoded"
            << std::setw(9) << "voxels" << std::setw(11) << "saturated" << std::setw(10)
            << "denoised" << std::setw(10) << "bytes" << std::setw(13) << "bytes/voxel"
            << std::setw(8) << "ratio" << std::setw(15) << "preprocess ms"
            << std::setw(11) << "encode ms" << std::setw(11) << "decode ms"
            << std::setw(12) << "denoise ms" << '\n';
  for (const StreamReport& report : reports) {
    const double frames = static_cast<double>(std::max<std::size_t>(report.frames, 1));
    const auto mean = [frames](auto sum) { return static_cast<double>(sum) / frames; };
    const double voxels = static_cast<double>(std::max<std::size_t>(report.voxels, 1));
    const double bytes = static_cast<double>(std::max<std::size_t>(report.bytes, 1));
    std::cout << std::left << std::setw(static_cast<int>(name_width)) << report.name
              << "  " << std::setw(9) << report.law << std::right << std::fixed
              << std::setw(8) << report.frames << std::setprecision(0) << std::setw(10)
              << mean(report.points) << std::setw(10) << mean(report.encoded_points)
              << std::setw(9) << mean(report.voxels) << std::setw(11)
              << mean(report.saturated_voxels) << std::setw(10)
              << mean(report.kept_voxels) << std::setw(10) << mean(report.bytes)
              << std::setprecision(3) << std::setw(13) << bytes / voxels
              << std::setprecision(1) << std::setw(8)
              << 16.0 * static_cast<double>(report.encoded_points) / bytes
              << std::setprecision(2) << std::setw(15) << mean(report.preprocess_ms)
              << std::setw(11) << mean(report.encode_ms) << std::setw(11)
              << mean(report.decode_ms) << std::setw(12) << mean(report.denoise_ms)
              << '\n';
  }
  std::cout
      << "points: finite ones; encoded: those in a voxel, the others were cropped or "
         "lie beyond the grid; saturated: voxels\nwhose intensity is beyond the "
         "scale; denoised: voxels that are left; ratio: 16 bytes for each encoded "
         "point, against bytes\n";
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
      // The other streams are none the worse for it.
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
  try {
    const std::optional<StreamOptions> options =
        pcl_ext::tools::parseOptions(argc, argv);
    return options ? run(*options) : 0;
  }
  catch (const std::exception& error) {
    std::cerr << "pcl_ext_stream: " << error.what() << '\n';
    return 1;
  }
}
