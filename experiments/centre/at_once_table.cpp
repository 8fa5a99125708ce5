// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * The paper's section 3.3: the streams of all six cameras at one central computer.
 */
#include "experiments/tables.h"
#include "measuring/results.h"
#include "simulator/robot_cell.h"
#include "stream_load.h"

#include <string>

namespace pcl_ext {
namespace experiments {

void
measureAtOnce(const Options& options, std::ostream& output)
{
  measuring::Results results(output);
  const measuring::Workload workload;
  for (const std::string& effort : options.efforts) {
    const measuring::Variant& variant = measuring::variantNamed(effort);
    StreamLoad load;
    load.streams = cell::RobotCell::sensor_count;
    load.frames_per_second = cell::RobotCell::frame_rate;
    load.seconds = options.seconds;
    load.i_frame_rate = workload.i_frame_rate;
    load.resolution = workload.resolution;
    load.min_intensity = 0.0f; // all voxels are merged
    // As many as are sent, as a decoder takes a frame that comes again for an old one.
    const LoadResult run =
        sendStreams(encodeCell(ticksOf(load), workload, variant), load);
    const measuring::Subject subject = {
        "at_once", "central", variant.name, workload.resolution};
    const auto frames = static_cast<double>(run.frames);
    results.add(subject, "seconds", run.seconds);
    results.add(subject, "frames_per_second", frames / run.seconds);
    results.add(
        subject, "late_percent", 100.0 * static_cast<double>(run.late) / frames);
    results.add(subject, "latency_ms", run.mean_latency_ms, run.frames);
    results.add(subject, "longest_latency_ms", run.max_latency_ms, run.frames);
    results.add(subject, "cpu_percent", 100.0 * run.cpu_seconds / run.seconds);
    results.add(subject,
                "memory_mb",
                run.megabytes_per_stream * static_cast<double>(load.streams));
    results.add(subject, "merge_ms", run.merge_ms);
    results.add(subject, "merged_voxels", static_cast<double>(run.merged_voxels));
  }
}

} // namespace experiments
} // namespace pcl_ext
