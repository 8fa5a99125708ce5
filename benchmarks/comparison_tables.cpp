#include "comparison_tables.h"

#include "coder_comparison.h"
#include "measuring/markdown_table.h"
#include "stage_times.h"
#include "table_cells.h"

#include <ostream>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief This library's coders and PCL's voxels. */
StreamCoders
makeLibraryAndPcl(const Workload& workload)
{
  StreamCoders coders;
  addLibraryCoders(workload, coders);
  addPclVoxelGridCoder(workload, coders);
  return coders;
}

/** \brief Root mean square and largest, millimetres; dashes if none were searched. */
std::pair<std::string, std::string>
millimetres(const NearestDistances& distances)
{
  if (distances.points == 0)
    return {"-", "-"};
  return {formatted(1000.0 * distances.rms(), 2),
          formatted(1000.0 * distances.largest, 2)};
}

} // namespace

void
printPeers(const ComparisonOptions& options, std::ostream& output)
{
  const Workload workload = workloadAt(0.04, options.i_frame_rate);
  ComparisonSettings settings;
  settings.error_every = options.error_every;
  settings.repetitions = options.repetitions;
  const Comparison comparison =
      compareCoders(openCellStream(options.sensor, options.frames),
                    workload,
                    makeAllCoders,
                    settings);
  output << "### All coders, robot cell, 4 cm, count\n\n"
         << formatted(comparison.coders.front().points.mean(), 0)
         << " points a frame. Times are median (mean) of a frame, ms.\n\n";
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
                       "error in to out mm, rms",
                       "largest",
                       "out to in mm, rms",
                       "largest"});
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
                  millimetres(coder.to_decoded).first,
                  millimetres(coder.to_decoded).second,
                  millimetres(coder.from_decoded).first,
                  millimetres(coder.from_decoded).second});
  table.print(output);
}

void
printEfforts(const ComparisonOptions& options, std::ostream& output)
{
  output << "### Efforts against the published layout and PCL, robot cell\n\n"
            "Times are medians, ms; in brackets how much faster than PCL's class.\n\n";
  ComparisonSettings settings;
  settings.repetitions = options.repetitions;
  MarkdownTable table({"workload",
                       "coder",
                       "voxels",
                       "bytes",
                       "against published",
                       "bytes per voxel",
                       "encode ms",
                       "decode ms"});
  const struct {
    const char* name;
    double resolution;
    IntensityLaw law;
  } workloads[] = {{"4 cm, count", 0.04, IntensityLaw::Count},
                   {"2 cm, count", 0.02, IntensityLaw::Count},
                   {"4 cm, quadratic", 0.04, IntensityLaw::Quadratic}};
  for (const auto& workload : workloads) {
    const Comparison comparison = compareCoders(
        openCellStream(options.sensor, options.frames),
        workloadAt(workload.resolution, options.i_frame_rate, workload.law),
        makeLibraryAndPcl,
        settings);
    const CoderFigures& pcl = pclOf(comparison);
    for (const CoderFigures& coder : comparison.coders)
      table.addRow({workload.name,
                    coder.name,
                    formatted(comparison.voxels(coder), 0),
                    formatted(coder.bytes.mean(), 0),
                    againstPublished(coder, comparison),
                    formatted(comparison.bytesPerVoxel(coder), 3),
                    timeAgainst(coder.encode_ms, pcl.encode_ms),
                    timeAgainst(coder.decode_ms, pcl.decode_ms)});
  }
  table.print(output);
}

void
printStages(const ComparisonOptions& options, std::ostream& output)
{
  output
      << "### Stages, robot cell, 4 cm, count\n\n"
         "Median (mean) of a frame, ms. Preprocessing starts at the organised cloud. "
         "Filling the cloud is\nwhat the class's decoding takes beyond the "
         "decoder's.\n\n";
  MarkdownTable table({"coder",
                       "preprocess",
                       "voxelize",
                       "code",
                       "class, encode",
                       "decode",
                       "fill cloud",
                       "class, decode"});
  for (const StageTimes& times :
       timeStages(openCellStream(options.sensor, options.frames),
                  workloadAt(0.04, options.i_frame_rate),
                  options.repetitions))
    table.addRow({times.name,
                  medianAndMean(times.preprocess),
                  medianAndMean(times.voxelize),
                  medianAndMean(times.code),
                  medianAndMean(times.class_encode),
                  medianAndMean(times.decode),
                  formatted(times.class_decode.median() - times.decode.median(), 2),
                  medianAndMean(times.class_decode)});
  table.print(output);
}

void
printRawToBytes(const ComparisonOptions& options, std::ostream& output)
{
  const std::vector<StageTimes> coders =
      timeRawToBytes(openCellStream(options.sensor, options.frames),
                     workloadAt(0.04, options.i_frame_rate),
                     options.repetitions);
  output
      << "### From the sensor's organised cloud to bytes, robot cell, 4 cm, count\n\n"
         "217,088 points in. Median (mean) of a frame, ms.\n\n";
  MarkdownTable table(
      {"way", "passes", "bytes", "move and crop", "compress", "total", "against PCL"});
  const StageTimes& pcl = coders.back();
  for (const StageTimes& coder : coders) {
    const bool has_one_pass = coder.preprocess.median() == 0.0;
    table.addRow({coder.name,
                  &coder == &pcl ? "transformPointCloud, CropBox, class"
                  : has_one_pass ? "one"
                                 : "SensorPreprocessor, class",
                  formatted(coder.bytes.mean(), 0),
                  has_one_pass ? "" : medianAndMean(coder.preprocess),
                  has_one_pass ? "" : medianAndMean(coder.class_encode),
                  medianAndMean(coder.raw_to_bytes),
                  factor(pcl.raw_to_bytes.median() / coder.raw_to_bytes.median())});
  }
  table.print(output);
}

} // namespace measuring
} // namespace pcl_ext
