// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * How many streams one central computer decodes and one link carries.
 */
#include "experiments/tables.h"
#include "measuring/markdown_table.h"
#include "simulator/robot_cell.h"
#include "stream_load.h"

#include <algorithm>
#include <cmath>
#include <ostream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace pcl_ext {
namespace experiments {

namespace {

using measuring::formatted;
using measuring::MarkdownTable;
using measuring::variantNamed;
using measuring::Workload;

/** \brief Bytes that a frame takes on Ethernet, sent over TCP by ROS.
 *
 * A segment of 1448 bytes (1500 less 20 of IPv4 and 32 of TCP with time stamps) takes
 * 90 more: those 52, 14 of Ethernet's header, 4 of checksum, 8 of preamble, 12 of gap.
 * Acknowledgements go the other way. The header, format and fields of the message take
 * about 135 bytes.
 */
double
bytesOnTheWire(double frame_bytes)
{
  constexpr double message_bytes = 135.0;
  constexpr double segment_bytes = 1448.0;
  constexpr double segment_overhead = 90.0;
  const double bytes = frame_bytes + message_bytes;
  return bytes + segment_overhead * std::ceil(bytes / segment_bytes);
}

constexpr double gigabit = 1e9;

/** \brief Mean of a frame; every stream has the same weight. */
double
meanPerFrame(const std::vector<SensorStream>& streams, std::size_t SensorStream::*sum)
{
  double mean = 0.0;
  for (const SensorStream& stream : streams)
    mean += static_cast<double>(stream.*sum) /
            static_cast<double>(stream.frames.size() * streams.size());
  return mean;
}

/** \brief A number of streams; "at least" if no more were tried. */
std::string
streamCount(std::size_t streams, const Options& options)
{
  return (streams == options.most_streams ? "at least " : "") +
         formatted(static_cast<double>(streams), 0);
}

MarkdownTable::Row
rowOf(const Options& options, const std::string& effort)
{
  const Workload workload = workloadOf(options);
  const std::vector<SensorStream> sources =
      encodeCell(options.frames, workload, variantNamed(effort));
  const double bytes = meanPerFrame(sources, &SensorStream::bytes);
  StreamLoad load;
  load.seconds = options.seconds;
  load.i_frame_rate = workload.i_frame_rate;
  load.resolution = workload.resolution;
  load.streams = std::min<std::size_t>(options.most_streams, 440);
  const LoadResult unpaced = sendStreams(sources, load);

  load.frames_per_second = cell::RobotCell::frame_rate;
  load.streams = options.most_streams;
  LoadResult one_thread;
  load.threads = 1;
  const std::size_t streams_of_one = mostStreams(sources, load, one_thread);
  LoadResult all_cores;
  load.threads = 0;
  const std::size_t streams_of_all = mostStreams(sources, load, all_cores);

  const double frame_rate = cell::RobotCell::frame_rate;
  return {
      effort,
      formatted(meanPerFrame(sources, &SensorStream::voxels), 0),
      formatted(bytes, 0),
      formatted(gigabit / (8.0 * frame_rate * bytes), 0),
      formatted(gigabit / (8.0 * frame_rate * bytesOnTheWire(bytes)), 0),
      streamCount(streams_of_one, options),
      streamCount(streams_of_all, options),
      formatted(all_cores.mean_latency_ms, 1) + " (" +
          formatted(all_cores.max_latency_ms, 1) + ")",
      formatted(100.0 * all_cores.cpu_seconds / all_cores.seconds, 0) + " %",
      formatted(static_cast<double>(unpaced.frames) / unpaced.seconds / frame_rate, 0),
      formatted(1e6 * unpaced.cpu_seconds / static_cast<double>(unpaced.frames), 0),
      formatted(unpaced.megabytes_per_stream, 2)};
}

} // namespace

void
printScale(const Options& options, std::ostream& output)
{
  if (const unsigned int rate = Workload().i_frame_rate;
      options.frames % rate != 0 || options.frames < frames_to_repeat)
    throw std::invalid_argument(
        "table scale: --frames is " + std::to_string(options.frames) +
        "; it must be a multiple of " + std::to_string(rate) + ", " +
        std::to_string(frames_to_repeat) +
        " at least, as streams are repeated from their first I-frame");
  output << "### Many streams, "
         << (options.temporal_filter != 0 ? "filtered over time at the sensors"
             : options.outlier_removal    ? "outliers removed at the sensors"
                                          : "one central computer")
         << "\n\nStreams at " << formatted(cell::RobotCell::frame_rate, 0)
         << " Hz and 4 cm; " << std::thread::hardware_concurrency()
         << " cores; runs of " << formatted(options.seconds, 1) << " s.";
  if (options.outlier_removal)
    output << " The sensors remove outliers, at log-odds "
           << formatted(static_cast<double>(*options.outlier_removal), 1) << '.';
  if (options.temporal_filter != 0)
    output << " The sensors filter voxels over " << options.temporal_filter
           << " frames.";
  output << "\n\n";
  MarkdownTable table({"effort",
                       "voxels",
                       "bytes a frame",
                       "streams in a gigabit",
                       "with TCP's and ROS's bytes",
                       "decoded in time, one decoding thread",
                       "one for each core",
                       "latency ms, mean (largest)",
                       "processor",
                       "as fast as it goes, all cores",
                       "processor us a frame",
                       "MB a stream"});
  for (const std::string& effort : options.efforts)
    table.addRow(rowOf(options, effort));
  table.print(output);
}

} // namespace experiments
} // namespace pcl_ext
