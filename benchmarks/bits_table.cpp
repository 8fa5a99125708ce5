/** \file
 * Bytes and decisions of denoising over the number of bits of an intensity.
 */
#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/point_intensity.h>

#include "comparison_tables.h"
#include "measuring/markdown_table.h"
#include "measuring/workload.h"
#include "table_cells.h"

#include <array>
#include <cmath>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief Thresholds of denoising, points. */
constexpr std::array<float, 3> thresholds{2.0f, 3.0f, 5.0f};

/** \brief Figures of a stream on one scale. */
struct ScaleFigures {
  std::size_t bytes = 0;
  std::size_t voxels = 0;
  std::array<std::size_t, thresholds.size()> changed{}; ///< decisions, by threshold
  double error = 0.0;                                   ///< sum of |error|, points
};

io::IntensityCompressionSettings
settingsOf(const Workload& workload, unsigned int bits, io::IntensityCurve curve)
{
  io::IntensityCompressionSettings settings;
  settings.resolution = workload.resolution;
  settings.i_frame_rate = workload.i_frame_rate;
  settings.intensity_bits = bits;
  settings.intensity_curve = curve;
  return settings;
}

void
addErrors(const io::VoxelFrame& decoded,
          const io::VoxelFrame& exact,
          ScaleFigures& figures)
{
  if (decoded.keys != exact.keys)
    throw std::runtime_error("the voxels depend on the scale");
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const float count = exact.intensity_scale.value(exact.intensities[i]);
    const float shown = decoded.intensity_scale.value(decoded.intensities[i]);
    for (std::size_t t = 0; t < thresholds.size(); ++t)
      figures.changed[t] +=
          (count >= thresholds[t]) != (shown >= thresholds[t]) ? 1 : 0;
    figures.error += std::abs(static_cast<double>(shown - count));
  }
}

/** \brief Encodes and decodes a stream on one scale.
 * \throws std::runtime_error if what is decoded is not what was encoded
 */
ScaleFigures
measureScale(const std::vector<InputFrame>& frames,
             const Workload& workload,
             const io::IntensityCompressionSettings& settings)
{
  io::IntensityCompressionSettings exact_settings =
      settingsOf(workload, 16, io::IntensityCurve::Linear);
  exact_settings.effort = io::Effort::Fast;
  io::CloudEncoder exact_encoder(exact_settings, IntensityUnit::Points);
  io::CloudEncoder encoder(settings, IntensityUnit::Points);
  io::FrameDecoder decoder;
  io::VoxelFrame exact;
  io::VoxelFrame encoded;
  io::VoxelFrame decoded;
  std::vector<std::uint8_t> bytes;
  ScaleFigures figures;
  for (const InputFrame& frame : frames) {
    // Each point counts as one. Both encoders fit their grids again at the same frames.
    const io::PointView view = pointViewOf(*frame.points);
    throwUnlessOk(exact_encoder.voxelize(view, WorldPose(), exact));
    throwUnlessOk(exact_encoder.encode(exact, std::nullopt, bytes));
    throwUnlessOk(encoder.voxelize(view, WorldPose(), encoded));
    throwUnlessOk(encoder.encode(encoded, std::nullopt, bytes));
    throwUnlessOk(decoder.decode(bytes.data(), bytes.size(), decoded));
    if (decoded.intensities != encoded.intensities ||
        decoded.intensity_scale != encoded.intensity_scale)
      throw std::runtime_error("the decoded frame differs from the encoded one");
    figures.bytes += bytes.size();
    figures.voxels += exact.size();
    addErrors(decoded, exact, figures);
  }
  return figures;
}

MarkdownTable::Row
rowOf(const std::string& name, const ScaleFigures& figures, const ScaleFigures& usual)
{
  const auto voxels = static_cast<double>(figures.voxels);
  const double percent =
      100.0 *
      (static_cast<double>(figures.bytes) / static_cast<double>(usual.bytes) - 1.0);
  MarkdownTable::Row row{name,
                         formatted(static_cast<double>(figures.bytes) / voxels, 3),
                         signedPercent(percent)};
  for (const std::size_t changed : figures.changed)
    row.push_back(changed == 0
                      ? "none"
                      : formatted(100.0 * static_cast<double>(changed) / voxels, 2) +
                            " %");
  row.push_back(formatted(figures.error / voxels, 3));
  return row;
}

void
printScales(const InputStream& stream, const Workload& workload, std::ostream& output)
{
  const std::vector<InputFrame> frames =
      readFrames(stream, workload, Keep::Preprocessed);
  MarkdownTable table({"bits",
                       "bytes per voxel",
                       "to 8 bits",
                       "changed at 2",
                       "changed at 3",
                       "changed at 5",
                       "mean error, points"});
  const ScaleFigures usual = measureScale(
      frames, workload, settingsOf(workload, 8, io::IntensityCurve::Linear));
  for (unsigned int bits = 1; bits <= 8; ++bits)
    table.addRow(rowOf(
        std::to_string(bits) + ", linear",
        measureScale(
            frames, workload, settingsOf(workload, bits, io::IntensityCurve::Linear)),
        usual));
  // With 8 bits the companded scale of counts is the linear one.
  for (unsigned int bits = 1; bits <= 7; ++bits)
    table.addRow(
        rowOf(std::to_string(bits) + ", companded",
              measureScale(frames,
                           workload,
                           settingsOf(workload, bits, io::IntensityCurve::Companded)),
              usual));
  output << "### Bits of a count: " << stream.clouds->name() << ", "
         << formatted(100.0 * workload.resolution, 0) << " cm, "
         << formatted(static_cast<double>(usual.voxels) /
                          static_cast<double>(frames.size()),
                      0)
         << " voxels\n\n";
  table.print(output);
}

} // namespace

void
printBits(const ComparisonOptions& options, std::ostream& output)
{
  for (const double resolution : {0.04, 0.1})
    printScales(openCellStream(options.sensor, options.frames),
                workloadAt(resolution, options.i_frame_rate),
                output);
  for (const InputStream& stream : openRecordedStreams(options.recordings))
    printScales(stream, workloadAt(0.04, options.i_frame_rate), output);
}

} // namespace measuring
} // namespace pcl_ext
