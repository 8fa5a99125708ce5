#include "comparison_tables.h"

#include "coder_comparison.h"
#include "measuring/markdown_table.h"
#include "raw_to_bytes.h"
#include "stage_times.h"

#include <algorithm>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace measuring {

namespace {

Workload
workloadAt(const ComparisonOptions& options, double resolution, Law law = Law::Count)
{
  Workload workload;
  workload.law = law;
  workload.resolution = resolution;
  workload.i_frame_rate = options.i_frame_rate;
  return workload;
}

/** \brief This library's coders and PCL's voxels. */
StreamCoders
makeLibraryAndPcl(const Workload& workload)
{
  StreamCoders coders;
  addLibraryCoders(workload, coders);
  addPclVoxelGridCoder(workload, coders);
  return coders;
}

const CoderFigures&
figuresOf(const Comparison& comparison, const std::string& name)
{
  return *std::find_if(comparison.coders.begin(),
                       comparison.coders.end(),
                       [&name](const CoderFigures& f) { return f.name == name; });
}

const CoderFigures&
publishedOf(const Comparison& comparison)
{
  return figuresOf(comparison, coderName(libraryVariants().back()));
}

const CoderFigures&
pclOf(const Comparison& comparison)
{
  return figuresOf(comparison, "PCL, voxel grid");
}

/** \brief "median (mean)" */
std::string
medianAndMean(const Samples& samples)
{
  return formatted(samples.median(), 2) + " (" + formatted(samples.mean(), 2) + ")";
}

std::string
factor(double faster)
{
  return formatted(faster, faster < 1.0 ? 2 : 1) + "x";
}

/** \brief The median, and how much faster it is than a reference's. */
std::string
timeAgainst(const Samples& samples, const Samples& reference)
{
  return formatted(samples.median(), 2) + " (" +
         factor(reference.median() / samples.median()) + ")";
}

/** \brief Bytes against the published layout's, in percent with a sign; nothing for what
 * does not carry the same. */
std::string
againstPublished(const CoderFigures& coder, const Comparison& comparison)
{
  if (coder.content != Content::VoxelsWithIntensity)
    return {};
  const double percent =
      100.0 * (coder.bytes.sum() / publishedOf(comparison).bytes.sum() - 1.0);
  return (percent > 0.0 ? "+" : "") + formatted(percent, 1) + " %";
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
  const Workload workload = workloadAt(options, 0.04);
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
    Law law;
  } workloads[] = {{"4 cm, count", 0.04, Law::Count},
                   {"2 cm, count", 0.02, Law::Count},
                   {"4 cm, quadratic", 0.04, Law::Quadratic}};
  for (const auto& workload : workloads) {
    const Comparison comparison =
        compareCoders(openCellStream(options.sensor, options.frames),
                      workloadAt(options, workload.resolution, workload.law),
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
                  workloadAt(options, 0.04),
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
  const std::vector<RawToBytesTimes> ways =
      timeRawToBytes(openCellStream(options.sensor, options.frames),
                     workloadAt(options, 0.04),
                     options.repetitions);
  output
      << "### From the sensor's organised cloud to bytes, robot cell, 4 cm, count\n\n"
         "217,088 points in. Median (mean) of a frame, ms.\n\n";
  MarkdownTable table(
      {"way", "passes", "bytes", "move and crop", "compress", "total", "against PCL"});
  for (const RawToBytesTimes& way : ways)
    table.addRow({way.name,
                  way.passes,
                  formatted(way.bytes.mean(), 0),
                  medianAndMean(way.move_and_crop),
                  medianAndMean(way.compress),
                  medianAndMean(way.total),
                  factor(ways.back().total.median() / way.total.median())});
  table.print(output);
}

void
printRecorded(const ComparisonOptions& options, std::ostream& output)
{
  if (options.recordings.empty())
    return;
  const Workload workload = workloadAt(options, 0.04);
  ComparisonSettings settings;
  settings.repetitions = options.repetitions;
  MarkdownTable::Row header = {"stream", "frames", "points", "voxels"};
  std::vector<MarkdownTable> tables;
  const std::vector<std::string> titles = {
      "bytes a frame (against published)",
      "encode ms, median (how much faster than PCL, voxel grid)",
      "decode ms, median (how much faster than PCL, voxel grid)"};
  for (const auto& coder : makeAllCoders(workload))
    header.push_back(coder->name());
  tables.resize(titles.size(), MarkdownTable(header));
  for (const InputStream& stream : openRecordedStreams(options.recordings)) {
    const Comparison comparison =
        compareCoders(stream, workload, makeAllCoders, settings);
    const MarkdownTable::Row start = {
        stream.clouds->name(),
        std::to_string(stream.clouds->size()),
        formatted(comparison.coders.front().points.mean(), 0),
        formatted(comparison.coders.front().decoded.mean(), 0)};
    MarkdownTable::Row bytes = start;
    MarkdownTable::Row encode_ms = start;
    MarkdownTable::Row decode_ms = start;
    const CoderFigures& pcl = pclOf(comparison);
    for (const CoderFigures& coder : comparison.coders) {
      const std::string change = againstPublished(coder, comparison);
      bytes.push_back(formatted(coder.bytes.mean(), 0) +
                      (change.empty() ? "" : " (" + change + ")"));
      encode_ms.push_back(timeAgainst(coder.encode_ms, pcl.encode_ms));
      decode_ms.push_back(timeAgainst(coder.decode_ms, pcl.decode_ms));
    }
    tables[0].addRow(bytes);
    tables[1].addRow(encode_ms);
    tables[2].addRow(decode_ms);
  }
  for (std::size_t i = 0; i < tables.size(); ++i) {
    output << "### Recorded clouds, 4 cm, count: " << titles[i] << "\n\n";
    tables[i].print(output);
  }
}

} // namespace measuring
} // namespace pcl_ext
