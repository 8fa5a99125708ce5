// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * The tables that compare coders.
 */
#include "measuring/markdown_table.h"
#include "meters/coder_comparison.h"
#include "tables/table_cells.h"
#include "tables/tables.h"

#include <ostream>
#include <string>

namespace pcl_ext {
namespace measuring {

namespace {

MarkdownTable
tableOf(const std::string& first_column)
{
  return MarkdownTable({first_column,
                        "coder",
                        "voxels",
                        "bytes",
                        "against published",
                        "bytes per voxel",
                        "encode ms",
                        "decode ms"});
}

/** \brief Adds a row for each coder. */
void
addRows(const std::string& first_cell,
        const Comparison& comparison,
        MarkdownTable& table)
{
  const CoderFigures& pcl = pclOf(comparison);
  for (const CoderFigures& coder : comparison.coders)
    table.addRow(
        {first_cell,
         coder.name,
         formatted(comparison.voxels(coder), 0),
         formatted(coder.bytes.mean(), 0),
         againstPublished(coder, comparison),
         formatted(comparison.bytesPerVoxel(coder), 3),
         timeAgainst(coder.encode_ms, pcl.encode_ms),
         // From the sensor's cloud only encoding is measured: decode() does nothing.
         pcl.decode_ms.median() < 0.01 ? ""
                                       : timeAgainst(coder.decode_ms, pcl.decode_ms)});
}

ComparisonSettings
settingsOf(const Options& options)
{
  ComparisonSettings settings;
  settings.repetitions = options.repetitions;
  return settings;
}

/** \brief Root mean square and largest, millimetres. */
std::string
millimetres(const NearestDistances& distances)
{
  return formatted(1000.0 * distances.rms(), 2) + " (" +
         formatted(1000.0 * distances.largest, 2) + ")";
}

} // namespace

void
printEfforts(const Options& options, std::ostream& output)
{
  output << "### Efforts against the published layout and PCL, robot cell\n\n"
            "Times are medians, ms; in brackets how much faster than PCL's class.\n\n";
  MarkdownTable table = tableOf("workload");
  const struct {
    const char* name;
    Workload workload;
  } workloads[] = {{"4 cm, count", workloadAt(0.04)},
                   {"2 cm, count", workloadAt(0.02)},
                   {"4 cm, quadratic", workloadAt(0.04, IntensityLaw::Quadratic)}};
  const auto make_coders = [](const Workload& workload) {
    StreamCoders coders;
    addLibraryCoders(workload, coders);
    addPclVoxelGridCoder(workload, coders);
    return coders;
  };
  for (const auto& [name, workload] : workloads)
    addRows(name,
            compareCoders(openCellStream(first_sensor, options.frames),
                          workload,
                          make_coders,
                          settingsOf(options)),
            table);
  table.print(output);
}

void
printFromSensor(const Options& options, std::ostream& output)
{
  output
      << "### From the sensor's organised cloud to bytes, robot cell\n\n"
         "217,088 points in; moving and cropping is part of encoding: PCL's "
         "transformPointCloud and CropBox,\nSensorPreprocessor, or SensorNode in one "
         "pass.\n\n";
  const InputStream stream = openCellStream(first_sensor, options.frames);
  ComparisonSettings settings = settingsOf(options);
  settings.keep = Keep::All;
  MarkdownTable table = tableOf("workload");
  addRows("4 cm, count",
          compareCoders(
              stream,
              workloadAt(0.04),
              [&stream](const Workload& workload) {
                return makeFromSensorCoders(stream, workload);
              },
              settings),
          table);
  table.print(output);
}

void
printPeers(const Options& options, std::ostream& output)
{
  ComparisonSettings settings = settingsOf(options);
  constexpr std::size_t frames_to_next_error = 10;
  settings.error_every = frames_to_next_error;
  const Comparison comparison =
      compareCoders(openCellStream(first_sensor, options.frames),
                    workloadAt(0.04),
                    makeAllCoders,
                    settings);
  output << "### All coders, robot cell, 4 cm, count\n\n"
         << formatted(comparison.coders.front().points.mean(), 0)
         << " points a frame. Times are median (mean) of a frame, ms; errors are root "
            "mean square (largest), mm.\n\n";
  MarkdownTable table({"coder",
                       "carries",
                       "voxels",
                       "bytes",
                       "bytes per voxel",
                       "ratio to 16 bytes a point",
                       "encode ms",
                       "decode ms",
                       "allocations, encode",
                       "decode",
                       "error in to out",
                       "out to in"});
  for (const CoderFigures& coder : comparison.coders)
    table.addRow({coder.name,
                  nameOf(coder.content),
                  formatted(comparison.voxels(coder), 0),
                  formatted(coder.bytes.mean(), 0),
                  formatted(comparison.bytesPerVoxel(coder), 3),
                  formatted(16.0 * coder.points.sum() / coder.bytes.sum(), 1),
                  medianAndMean(coder.encode_ms),
                  medianAndMean(coder.decode_ms),
                  formatted(coder.encode_allocations.median(), 0),
                  formatted(coder.decode_allocations.median(), 0),
                  millimetres(coder.to_decoded),
                  millimetres(coder.from_decoded)});
  table.print(output);
}

void
printRecorded(const Options& options, std::ostream& output)
{
  MarkdownTable table = tableOf("stream, frames");
  for (const InputStream& stream : openRecordedStreams(options.recordings))
    addRows(stream.clouds->name() + ", " + std::to_string(stream.clouds->size()),
            compareCoders(stream, workloadAt(0.04), makeAllCoders, settingsOf(options)),
            table);
  output << "### Recorded clouds, 4 cm, count\n\n";
  table.print(output);
}

} // namespace measuring
} // namespace pcl_ext
