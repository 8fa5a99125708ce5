// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * The tables of coders that keep all points.
 */
#include "measuring/markdown_table.h"
#include "meters/coder_comparison.h"
#include "tables/table_cells.h"
#include "tables/tables.h"

#include <algorithm>
#include <optional>
#include <ostream>
#include <string>

namespace pcl_ext {
namespace measuring {

namespace {

std::string
edgeName(double edge)
{
  return edge < 0.01 ? formatted(1e3 * edge, edge < 0.001 ? 1 : 0) + " mm"
                     : formatted(1e2 * edge, 0) + " cm";
}

/** \brief The median; nothing of what was not timed. */
std::string
milliseconds(const Samples& samples)
{
  return samples.median() < 0.01 ? "" : formatted(samples.median(), 1);
}

} // namespace

void
printPoints(const Options& options, std::ostream& output)
{
  ComparisonSettings settings;
  settings.repetitions = options.repetitions;
  settings.error_every = 1;
  settings.keep = Keep::All;
  const auto make_coders = [&options](const Workload& workload) {
    return makePointsCoders(workload, options.cloudini);
  };
  std::optional<MarkdownTable> sizes;
  MarkdownTable details({"stream, frames of points",
                         "edge",
                         "coder",
                         "bytes",
                         "bits a point",
                         "encode ms",
                         "decode ms",
                         "largest error, mm"});
  for (const InputStream& stream : openRecordedStreams(options.recordings))
    for (const double edge : options.edgesOr({0.001, 0.01, 0.04})) {
      const Comparison comparison =
          compareCoders(stream, workloadAt(edge), make_coders, settings);
      const std::string frames = stream.clouds->name() + ", " +
                                 std::to_string(stream.clouds->size()) + " of " +
                                 formatted(comparison.coders.front().points.mean(), 0);
      MarkdownTable::Row header = {"stream, frames of points", "edge"};
      MarkdownTable::Row row = {frames, edgeName(edge)};
      for (const CoderFigures& coder : comparison.coders) {
        header.push_back(coder.name);
        row.push_back(formatted(1e-3 * coder.bytes.mean(), 1));
        const double error = std::max(coder.to_decoded.largest_of_axis,
                                      coder.from_decoded.largest_of_axis);
        details.addRow({frames,
                        edgeName(edge),
                        coder.name,
                        formatted(coder.bytes.mean(), 0),
                        formatted(8.0 * coder.bytes.sum() / coder.points.sum(), 2),
                        milliseconds(coder.encode_ms),
                        milliseconds(coder.decode_ms),
                        coder.to_decoded.points == 0 ? "" : formatted(1e3 * error, 3)});
      }
      if (!sizes)
        sizes.emplace(header);
      sizes->addRow(row);
    }
  output << "### All points, kB a frame\n\n";
  if (sizes)
    sizes->print(output);
  output << "### All points, times and errors\n\n";
  details.print(output);
}

} // namespace measuring
} // namespace pcl_ext
