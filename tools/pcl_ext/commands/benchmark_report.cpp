// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "commands/benchmark_report.h"

#include <pcl_ext/version.h>

#include "console/printable_text.h"
#include "measuring/markdown_table.h"
#include "options/text_values.h"
#include "simd/vector_choice.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <ostream>
#include <sstream>
#include <utility>

namespace pcl_ext::tools {

namespace {

using measuring::formatted;
using measuring::MarkdownTable;

constexpr std::array<std::pair<const char*, std::size_t>, 3> percentiles = {
    {{"p50", 500}, {"p99", 990}, {"p99.9", 999}}};

/** \brief A sum over frames, divided by a number; none if that is 0. */
std::optional<double>
quotient(double sum, double number)
{
  return number > 0.0 ? std::optional(sum / number) : std::nullopt;
}

std::optional<double>
nanosecondsAVoxel(const StepTimes& step, const BenchmarkRow& row)
{
  return step.ms.count() == 0
             ? std::nullopt
             : quotient(1e6 * step.ms.sum(), static_cast<double>(row.voxels));
}

std::optional<double>
cyclesAVoxel(const StepTimes& step, const BenchmarkRow& row)
{
  return step.cycles == 0 ? std::nullopt
                          : quotient(static_cast<double>(step.cycles),
                                     static_cast<double>(row.voxels));
}

/** \brief By the stamps of the clouds. */
std::optional<double>
kilobitsASecond(const BenchmarkRow& row)
{
  return quotient(8e-3 * static_cast<double>(row.bytes),
                  static_cast<double>(row.frames) * row.period);
}

std::string
textOf(const std::optional<double>& value, int digits)
{
  return value ? formatted(*value, digits) : "-";
}

void
printTimes(const BenchmarkReport& report, std::ostream& output)
{
  MarkdownTable::Row header = {"stream", "effort", "ms of"};
  for (const auto& [name, per_mille] : percentiles)
    header.emplace_back(name);
  header.insert(header.end(), {"worst", "ns a voxel"});
  if (report.has_cycles)
    header.emplace_back("cycles a voxel");
  MarkdownTable table(header);
  for (const BenchmarkRow& row : report.rows)
    for (std::size_t i = 0; i < benchmark_steps.size(); ++i) {
      const StepTimes& step = row.steps[i];
      MarkdownTable::Row cells = {row.stream, row.effort, benchmark_steps[i]};
      for (const auto& [name, per_mille] : percentiles)
        cells.push_back(textOf(step.ms.percentile(per_mille), 2));
      cells.push_back(step.ms.count() == 0 ? "-" : formatted(step.ms.largest(), 2));
      cells.push_back(textOf(nanosecondsAVoxel(step, row), 0));
      if (report.has_cycles)
        cells.push_back(textOf(cyclesAVoxel(step, row), 0));
      table.addRow(cells);
    }
  table.print(output);
  output
      << "Wall-clock milliseconds of a frame, the first frames among them; nearest "
         "ranks. -: too few frames,\nas only the worst one is above. a voxel: mean of "
         "all frames.\n";
}

void
printSizes(const BenchmarkReport& report, std::ostream& output)
{
  MarkdownTable table({"stream",
                       "effort",
                       "clouds",
                       "frames",
                       "points",
                       "voxels",
                       "bytes",
                       "kbit/s",
                       "filter removes"});
  std::string remarks;
  for (const BenchmarkRow& row : report.rows) {
    const auto mean = [&row](std::size_t sum) {
      return textOf(quotient(static_cast<double>(sum), static_cast<double>(row.frames)),
                    0);
    };
    const std::optional<double> removed = quotient(
        100.0 * static_cast<double>(row.removed), static_cast<double>(row.voxels));
    table.addRow(
        {row.stream,
         row.effort,
         std::to_string(row.clouds),
         std::to_string(row.frames),
         mean(row.points),
         mean(row.voxels),
         mean(row.bytes),
         textOf(kilobitsASecond(row), 0),
         row.filter_failure.empty() && removed ? formatted(*removed, 1) + " %" : "-"});
    if (!row.filter_failure.empty())
      remarks +=
          row.stream + ", " + row.effort + ": no filter: " + row.filter_failure + '\n';
  }
  output << '\n';
  table.print(output);
  output
      << "points, voxels, bytes: means of a frame; of points in order, which have no "
         "voxels, the points.\nkbit/s: by the stamps of the "
         "clouds.\nFewer clouds than frames are repeated, with the same noise again, "
         "which takes fewer bytes than new ones.\n";
  for (const BenchmarkRow& row : report.rows)
    if (row.effort == report.rows.front().effort && row.has_assumed_period &&
        row.period > 0.0)
      output << row.stream << ": nothing tells the times of its clouds: "
             << formatted(1.0 / row.period, 1)
             << " a second are assumed; --rate sets it\n";
  output << remarks;
}

} // namespace

void
printBenchmark(const BenchmarkReport& report, std::ostream& output)
{
  const measuring::Machine& machine = report.machine;
  std::ostringstream resolution;
  resolution << report.resolution;
  output << "pcl_ext " << version() << ", " << machine.compiler
         << ", vectors: " << vectorsInUse() << '\n'
         << machine.processor << ", " << counted(machine.cores, "core") << ", "
         << formatted(machine.memory_gigabytes, 1) << " GB; " << machine.system << '\n'
         << "Load average: " << formatted(machine.load, 2) << " at the start, "
         << formatted(report.load_at_end, 2) << " at the end\n"
         << "Settings: resolution " << resolution.str() << " m, law " << report.law
         << ", an I-frame every " << report.i_frame_rate
         << " frames, one thread; given:" << (report.given.empty() ? " none" : "")
         << printable(report.given) << '\n'
         << "Peak resident memory of the program: "
         << formatted(report.peak_megabytes, 0) << " MB, of these "
         << formatted(report.held_megabytes, 0)
         << " MB before the first frame, mostly clouds\n\n";
  printTimes(report, output);
  printSizes(report, output);
}

nlohmann::ordered_json
toJson(const BenchmarkReport& report)
{
  using Json = nlohmann::ordered_json;
  const auto number = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json();
  };
  const measuring::Machine& machine = report.machine;
  Json json = {{"version", version()},
               {"processor", machine.processor},
               {"cores", machine.cores},
               {"memory_gb", machine.memory_gigabytes},
               {"system", machine.system},
               {"compiler", machine.compiler},
               {"vectors", vectorsInUse()},
               {"load_at_start", machine.load},
               {"load_at_end", report.load_at_end},
               {"resolution_m", report.resolution},
               {"law", report.law},
               {"i_frame_rate", report.i_frame_rate},
               {"options", report.given},
               {"peak_resident_mb", report.peak_megabytes},
               {"resident_before_mb", report.held_megabytes},
               {"results", Json::array()}};
  for (const BenchmarkRow& row : report.rows) {
    Json result = {
        {"stream", row.stream},
        {"effort", row.effort},
        {"clouds", row.clouds},
        {"frames", row.frames},
        {"points", row.points},
        {"voxels", row.voxels},
        {"bytes", row.bytes},
        {"removed_voxels", row.removed},
        {"period_s",
         number(row.period > 0.0 ? std::optional(row.period) : std::nullopt)},
        {"period_is_assumed", row.has_assumed_period},
        {"kbit_s", number(kilobitsASecond(row))},
        {"filter_failure", row.filter_failure}};
    for (std::size_t i = 0; i < benchmark_steps.size(); ++i) {
      const StepTimes& step = row.steps[i];
      Json times;
      for (const auto& [name, per_mille] : percentiles)
        times[std::string(name) + "_ms"] = number(step.ms.percentile(per_mille));
      times["worst_ms"] = step.ms.count() == 0 ? Json() : Json(step.ms.largest());
      times["ns_a_voxel"] = number(nanosecondsAVoxel(step, row));
      times["cycles_a_voxel"] = number(cyclesAVoxel(step, row));
      result[benchmark_steps[i]] = times;
    }
    json["results"].push_back(result);
  }
  return json;
}

} // namespace pcl_ext::tools
