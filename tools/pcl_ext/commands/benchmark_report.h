// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "measuring/machine.h"
#include "measuring/samples.h"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief What is done with each cloud, in this order. */
constexpr std::array<const char*, 3> benchmark_steps = {"encode", "decode", "filter"};

/** \brief What one step took: wall-clock milliseconds of each frame, cycles of all. */
struct StepTimes {
  measuring::Samples ms;
  std::uint64_t cycles = 0;
};

/** \brief Figures of one stream with one effort; sums over its frames. */
struct BenchmarkRow {
  std::string stream;
  std::string effort;
  std::size_t clouds = 0; ///< that are encoded in turn
  std::size_t frames = 0;
  std::size_t points = 0;  ///< finite ones
  std::size_t voxels = 0;  ///< of scans, which have none, the points
  std::size_t removed = 0; ///< voxels, by the filter
  std::size_t bytes = 0;
  double period = 0.0; ///< see HeldClouds
  bool has_assumed_period = false;
  std::string filter_failure; ///< empty: the filter judged all frames
  std::array<StepTimes, benchmark_steps.size()> steps;
};

/** \brief All that a run of the benchmark tells. */
struct BenchmarkReport {
  measuring::Machine machine;
  double load_at_end = 0.0;
  double resolution = 0.0; ///< metres
  std::string law;
  std::size_t i_frame_rate = 0;
  std::string given; ///< options as the user gave them
  bool has_cycles = false;
  double held_megabytes = 0.0; ///< resident before the first frame, with all clouds
  double peak_megabytes = 0.0;
  std::vector<BenchmarkRow> rows;
};

/** \brief Prints what belongs into a report, and tables. */
void
printBenchmark(const BenchmarkReport& report, std::ostream& output);

/** \brief The same for programs; null for what cannot be told. */
nlohmann::ordered_json
toJson(const BenchmarkReport& report);

} // namespace pcl_ext::tools
