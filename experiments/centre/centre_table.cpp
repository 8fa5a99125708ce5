// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * What many streams cost that are received, decoded, merged and encoded as one.
 */
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/nodes/central_node.h>

#include "experiments/tables.h"
#include "measuring/machine.h"
#include "measuring/markdown_table.h"
#include "measuring/samples.h"
#include "nodes/merged_frame_encoder.h"
#include "simulator/robot_cell.h"
#include "stream_load.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <future>
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
using nodes::Time;
using Bytes = std::vector<std::uint8_t>;

constexpr double rate = 20.0; // of all streams and of the merged one, Hz
constexpr unsigned int i_frame_rate = 300;
// I-frames, and the first frames of changes, for which memory is allocated.
constexpr std::size_t first_ticks = 3;
constexpr double cell_distance = 12.0; // metres

io::StreamSettings
streamSettings(io::Effort effort)
{
  io::StreamSettings settings;
  settings.effort = effort;
  settings.i_frame_rate = i_frame_rate;
  return settings;
}

/** \brief The streams of a sensor in other cells: the same voxels further along x. */
class MovedStream {
public:
  MovedStream(double resolution, io::Effort effort)
  : voxels_apart_(static_cast<std::int32_t>(cell_distance / resolution))
  , encoder_(streamSettings(effort))
  {}

  std::vector<Bytes>
  moved(const SensorStream& source, std::size_t cell)
  {
    std::vector<Bytes> frames;
    io::FrameDecoder decoder;
    io::VoxelFrame voxels;
    for (const Bytes& bytes : source.frames) {
      measuring::throwUnlessOk(decoder.decode(bytes.data(), bytes.size(), voxels));
      voxels.grid.first_index[0] += voxels_apart_ * static_cast<std::int32_t>(cell);
      measuring::throwUnlessOk(
          encoder_.encode(voxels, Time(0), "", frames.emplace_back()));
    }
    return frames;
  }

private:
  std::int32_t voxels_apart_;
  nodes::MergedFrameEncoder encoder_;
};

/** \brief How long it took to encode a merged frame. */
struct Encoding {
  Time latency{};       ///< since it was due
  double seconds = 0.0; ///< of the processor
};

/** \brief Processor time of the three stages, and what came of them. */
struct CentreRun {
  double decode_seconds = 0.0;
  double merge_seconds = 0.0;
  double encode_seconds = 0.0;
  std::size_t frames = 0; ///< of all streams
  std::size_t merged_voxels = 0;
  std::size_t merged_bytes = 0;
  measuring::Samples latencies; ///< milliseconds from due to encoded
};

/** \brief Sends a frame of each stream 20 times a second, merges them, and encodes what is
 * merged, while the next ones are decoded, as MergingCentre does. */
class Centre {
public:
  Centre(const std::vector<std::vector<Bytes>>& streams,
         double resolution,
         io::Effort effort)
  : streams_(streams), node_(settingsOf(resolution)), encoder_(streamSettings(effort))
  {
    for (std::size_t i = 0; i < streams_.size(); ++i)
      node_.addStream(std::to_string(i));
  }

  CentreRun
  run(std::size_t ticks)
  {
    CentreRun run;
    for (std::size_t tick = 0; tick < first_ticks; ++tick)
      sendTick(tick, nodes::systemTime(), run);
    finishEncoding(run);
    run = CentreRun();
    const double begin = measuring::processCpuSeconds();
    const auto period =
        std::chrono::duration_cast<Time>(std::chrono::duration<double>(1.0 / rate));
    Time due = nodes::systemTime() + period;
    for (std::size_t tick = 0; tick < ticks; ++tick, due += period) {
      if (due > nodes::systemTime())
        std::this_thread::sleep_for(due - nodes::systemTime());
      sendTick(first_ticks + tick, due, run);
    }
    finishEncoding(run);
    run.decode_seconds =
        measuring::processCpuSeconds() - begin - run.merge_seconds - run.encode_seconds;
    for (const nodes::StreamHealth& health : node_.health())
      if (health.frames_failed + health.frames_refused > 0)
        throw std::runtime_error("a frame failed: " + health.last_failure.message());
    return run;
  }

private:
  static nodes::CentralNodeSettings
  settingsOf(double resolution)
  {
    nodes::CentralNodeSettings settings;
    settings.resolution = resolution;
    return settings;
  }

  void
  sendTick(std::size_t tick, Time due, CentreRun& run)
  {
    for (std::size_t i = 0; i < streams_.size(); ++i)
      node_.receive(std::to_string(i), streams_[i][tick % streams_[i].size()], Time(0));
    node_.waitUntilDecoded();
    finishEncoding(run);
    const double decoded = measuring::processCpuSeconds();
    node_.mergeChanges(changes_);
    run.merge_seconds += measuring::processCpuSeconds() - decoded;
    run.frames += streams_.size();
    encoding_ = std::async(std::launch::async, [this, due] { return encode(due); });
  }

  /** \brief Encodes what was merged; time from when it was due, and of the processor. */
  Encoding
  encode(Time due)
  {
    const double begin = measuring::threadCpuSeconds();
    const auto voxels = [this]() -> const io::VoxelFrame& {
      node_.mergedVoxels(merged_);
      return merged_;
    };
    measuring::throwUnlessOk(encoder_.encode(changes_, voxels, Time(0), "", bytes_));
    return {nodes::systemTime() - due, measuring::threadCpuSeconds() - begin};
  }

  /** \brief Waits until what was merged last is encoded. */
  void
  finishEncoding(CentreRun& run)
  {
    if (!encoding_.valid())
      return;
    const Encoding encoding = encoding_.get();
    run.latencies.add(
        std::chrono::duration<double, std::milli>(encoding.latency).count());
    run.encode_seconds += encoding.seconds;
    run.merged_voxels = encoder_.statistics().voxels;
    run.merged_bytes += bytes_.size();
  }

  const std::vector<std::vector<Bytes>>& streams_;
  nodes::CentralNode node_;
  nodes::MergedFrameEncoder encoder_;
  nodes::MergedChanges changes_;
  io::VoxelFrame merged_; // keeps its memory
  Bytes bytes_;
  std::future<Encoding> encoding_;
};

MarkdownTable::Row
rowOf(const CentreRun& run, std::size_t streams, std::size_t ticks)
{
  const auto of_frame = [&](double seconds) {
    return formatted(1e6 * seconds / static_cast<double>(run.frames), 0);
  };
  const double all = run.decode_seconds + run.merge_seconds + run.encode_seconds;
  return {
      formatted(static_cast<double>(streams), 0),
      formatted(static_cast<double>(run.merged_voxels), 0),
      formatted(static_cast<double>(run.merged_bytes) / static_cast<double>(ticks), 0),
      of_frame(run.decode_seconds),
      of_frame(run.merge_seconds),
      of_frame(run.encode_seconds),
      of_frame(all),
      formatted(run.latencies.median(), 1),
      formatted(run.latencies.largest(), 1),
      formatted(100.0 * all * rate / static_cast<double>(ticks), 0) + " %"};
}

} // namespace

void
printCentre(const Options& options, std::ostream& output)
{
  const auto ticks = static_cast<std::size_t>(options.seconds * rate);
  if (options.frames < frames_to_repeat && options.frames < first_ticks + ticks)
    throw std::invalid_argument(
        "table centre: --frames is " + std::to_string(options.frames) +
        "; it must be --seconds * 20 + " + std::to_string(first_ticks) + ", or " +
        std::to_string(frames_to_repeat) +
        ", at least, as streams are repeated from their first frame");
  Workload workload = workloadOf(options);
  workload.i_frame_rate = i_frame_rate;
  const measuring::Variant& variant = measuring::variantNamed(options.efforts.front());
  const std::vector<SensorStream> sources =
      encodeCell(options.frames, workload, variant);
  output << "### A centre that decodes, merges and encodes\n\n"
            "The robot cell's six cameras, repeated in cells "
         << formatted(cell_distance, 0) << " m apart, 4 cm, number of points, effort "
         << variant.name << ", ";
  if (workload.outlier_removal)
    output << "outliers removed at the sensors, ";
  if (workload.temporal_filter != 0)
    output << "filtered over " << workload.temporal_filter << " frames, ";
  output << formatted(rate, 0) << " Hz; " << std::thread::hardware_concurrency()
         << " cores. Processor time of a frame of a stream, microseconds.\n\n";
  MarkdownTable table({"streams",
                       "merged voxels",
                       "bytes a merged frame",
                       "decode",
                       "merge",
                       "encode",
                       "sum",
                       "latency ms, median",
                       "largest",
                       "processor"});
  std::vector<std::vector<Bytes>> streams;
  for (const std::size_t count : {24u, 96u, 220u, 300u, 440u}) {
    if (count > options.most_streams)
      break;
    while (streams.size() < count) {
      MovedStream moved(workload.resolution, variant.effort);
      streams.push_back(moved.moved(sources[streams.size() % sources.size()],
                                    streams.size() / sources.size()));
    }
    Centre centre(streams, workload.resolution, variant.effort);
    table.addRow(rowOf(centre.run(ticks), count, ticks));
  }
  table.print(output);
}

} // namespace experiments
} // namespace pcl_ext
