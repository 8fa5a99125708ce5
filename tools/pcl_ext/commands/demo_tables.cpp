#include "commands/demo_tables.h"

#include "measuring/markdown_table.h"

#include <algorithm>
#include <ostream>
#include <sstream>

namespace pcl_ext {
namespace tools {

namespace {

using measuring::formatted;
using measuring::MarkdownTable;

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
addDenoisingRow(const DemoReport& report,
                const std::string& method,
                const RemovedVoxels& removed,
                bool is_used,
                MarkdownTable& table)
{
  const DenoisingReport& denoising = report.denoising;
  const std::size_t surfaces = denoising.labelled_voxels - denoising.noise_voxels;
  table.addRow({report.name,
                method + (is_used ? " (denoised clouds)" : ""),
                percent(removed.all, report.encoded.voxels),
                percent(denoising.noise_voxels, denoising.labelled_voxels),
                percent(removed.noise, denoising.noise_voxels),
                percent(surfaces - removed.surfaces, surfaces)});
}

} // namespace

void
printSizes(const std::vector<DemoReport>& reports, std::ostream& output)
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
                       "encode ms",
                       "decode ms",
                       "denoise ms"});
  for (const DemoReport& report : reports) {
    const EncodedSums& sums = report.encoded;
    const double frames = static_cast<double>(std::max<std::size_t>(sums.frames, 1));
    const auto mean = [frames](auto sum, int digits) {
      return formatted(static_cast<double>(sum) / frames, digits);
    };
    const double voxels = static_cast<double>(std::max<std::size_t>(sums.voxels, 1));
    const double bytes = static_cast<double>(std::max<std::size_t>(sums.bytes, 1));
    table.addRow({report.name,
                  report.law,
                  std::to_string(sums.frames),
                  mean(sums.points, 0),
                  mean(sums.encoded_points, 0),
                  mean(sums.voxels, 0),
                  mean(sums.saturated_voxels, 0),
                  mean(sums.bytes, 0),
                  formatted(bytes / voxels, 3),
                  formatted(16.0 * static_cast<double>(sums.encoded_points) / bytes, 1),
                  mean(report.encode_ms, 2),
                  mean(report.decode_ms, 2),
                  mean(report.denoising.ms, 2)});
  }
  output << "Means of a frame:\n";
  table.print(output);
  output
      << "points: finite ones. encoded: points in voxels; the others were cropped or "
         "are outside the grid.\nsaturated: voxels whose intensity is above the "
         "scale. ratio: 16 bytes for each encoded\npoint against the bytes. ms: "
         "processor time; encoding begins with the sensor's cloud.\n";
}

void
printDenoising(const std::vector<DemoReport>& reports, std::ostream& output)
{
  MarkdownTable table(
      {"stream", "denoising", "removed", "noise", "noise removed", "surfaces kept"});
  for (const DemoReport& report : reports) {
    const DenoisingReport& denoising = report.denoising;
    std::ostringstream threshold;
    threshold << "threshold " << denoising.threshold;
    addDenoisingRow(
        report, threshold.str(), denoising.by_threshold, !denoising.uses_filter, table);
    if (denoising.has_filter)
      addDenoisingRow(
          report, "outlier filter", denoising.by_filter, denoising.uses_filter, table);
  }
  output << "\nDenoising, shares of the voxels:\n";
  table.print(output);
  output
      << "threshold: a voxel of fewer points is removed, as in the paper; far surfaces "
         "go with the noise.\noutlier filter: also what lies around a voxel decides. "
         "noise: voxels without a point of a\nsurface, known in the robot cell.\n";
}

void
printTemporalFilter(const std::vector<DemoReport>& reports, std::ostream& output)
{
  if (!reports.front().filtered)
    return;
  MarkdownTable table({"stream",
                       "voxels",
                       "bytes",
                       "of those above",
                       "encode ms",
                       "decode ms",
                       "surfaces shown",
                       "noise hidden"});
  for (const DemoReport& report : reports) {
    const FilteredReport& filtered = *report.filtered;
    const double frames =
        static_cast<double>(std::max<std::size_t>(report.encoded.frames, 1));
    const auto mean = [frames](auto sum, int digits) {
      return formatted(static_cast<double>(sum) / frames, digits);
    };
    table.addRow({report.name,
                  mean(filtered.voxels, 0),
                  mean(filtered.bytes, 0),
                  percent(filtered.bytes, report.encoded.bytes),
                  mean(filtered.encode_ms, 2),
                  mean(filtered.decode_ms, 2),
                  percent(filtered.surfaces_shown, filtered.surfaces),
                  percent(filtered.noise_hidden, filtered.noise)});
  }
  output << "\nThe same clouds with --temporal-filter="
         << reports.front().filtered->frames_of_filter << ", means of a frame:\n";
  table.print(output);
  output
      << "surfaces shown: voxels of surfaces that are at most one voxel from a shown "
         "one.\nnoise hidden: voxels of noise that are not shown.\n";
}

} // namespace tools
} // namespace pcl_ext
