/** \file
 * Google Benchmark of each stage over the number of points, 1,000 to 10,000,000 at 4 cm,
 * and over the voxel edge, 50 cm to 5 mm at 1,000,000 points, on the sampled room.
 */
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/compression/voxelizer.h>
#include <pcl_ext/filters/sensor_preprocessor.h>

#include "frame_buffer.h"
#include "sampled_room.h"
#include "workload.h"

#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::benchmarks;

using Compression = io::OctreePointCloudIntensityCompression<pcl::PointXYZI>;

/** \brief Frames that are coded in turn, the first one of them as an I-frame. */
constexpr unsigned int frames_in_turn = 4;

/** \brief What is set by the second argument, the voxel edge in millimetres. */
Workload
workloadOf(const benchmark::State& state)
{
  Workload workload;
  workload.resolution = static_cast<double>(state.range(1)) / 1000.0;
  workload.i_frame_rate = frames_in_turn;
  return workload;
}

std::size_t
pointsOf(const benchmark::State& state)
{
  return static_cast<std::size_t>(state.range(0));
}

/** \brief Says what a stage's time is a function of: points or voxels. */
void
reportSize(benchmark::State& state, std::size_t size)
{
  const auto signed_size = static_cast<std::int64_t>(size);
  state.SetComplexityN(signed_size);
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * signed_size);
}

PositionCloud
rawCloud(const benchmark::State& state, std::uint32_t frame)
{
  PositionCloud raw;
  SampledRoom(pointsOf(state)).capture(frame, raw);
  return raw;
}

IntensityCloud::Ptr
preprocessedCloud(const benchmark::State& state, std::uint32_t frame)
{
  const IntensityCloud::Ptr points(new IntensityCloud);
  makePreprocessing(workloadOf(state), SampledRoom::sensorPose(), std::nullopt)(
      rawCloud(state, frame), *points);
  return points;
}

std::vector<io::VoxelFrame>
voxelFrames(const benchmark::State& state,
            const io::IntensityCompressionSettings& settings)
{
  io::Voxelizer voxelizer(settings, IntensityUnit::Native);
  std::vector<io::VoxelFrame> frames(frames_in_turn);
  for (std::uint32_t i = 0; i < frames_in_turn; ++i)
    voxelizer.voxelize(viewOf(*preprocessedCloud(state, i)), i == 0, frames[i]);
  // A grid that grew on the way would make I-frames of its own.
  for (std::uint32_t i = 0; i < frames_in_turn; ++i)
    voxelizer.voxelize(viewOf(*preprocessedCloud(state, i)), false, frames[i]);
  return frames;
}

template <typename StatusT>
bool
isOk(benchmark::State& state, const StatusT& status)
{
  if (!status.ok())
    state.SkipWithError(status.message().c_str());
  return status.ok();
}

/* Each stage runs once before it is timed, so that its memory has been used. */

void
preprocess(benchmark::State& state)
{
  const PositionCloud raw = rawCloud(state, 0);
  const Preprocessing preprocessing =
      makePreprocessing(workloadOf(state), SampledRoom::sensorPose(), std::nullopt);
  IntensityCloud points;
  preprocessing(raw, points);
  for (auto _ : state) {
    preprocessing(raw, points);
    benchmark::DoNotOptimize(points.points.data());
  }
  reportSize(state, raw.size());
}

void
voxelize(benchmark::State& state)
{
  const IntensityCloud::Ptr points = preprocessedCloud(state, 0);
  io::Voxelizer voxelizer(
      compressionSettings(workloadOf(state), libraryVariants().front()),
      IntensityUnit::Native);
  io::VoxelFrame frame;
  voxelizer.voxelize(viewOf(*points), false, frame);
  for (auto _ : state) {
    voxelizer.voxelize(viewOf(*points), false, frame);
    benchmark::DoNotOptimize(frame.keys.data());
  }
  reportSize(state, points->size());
}

/** \brief Times an action that takes the frames in turn and may fail. */
template <typename ActionT>
void
timeInTurn(benchmark::State& state, ActionT&& action)
{
  for (std::size_t i = 0; i < frames_in_turn; ++i)
    if (!isOk(state, action(i)))
      return;
  std::size_t next = 0;
  for (auto _ : state) {
    if (!isOk(state, action(next)))
      return;
    next = (next + 1) % frames_in_turn;
  }
}

void
code(benchmark::State& state, const Variant& variant)
{
  const auto settings = compressionSettings(workloadOf(state), variant);
  const std::vector<io::VoxelFrame> frames = voxelFrames(state, settings);
  io::FrameEncoder encoder = makeFrameEncoder(settings);
  std::vector<std::uint8_t> bytes;
  timeInTurn(state, [&](std::size_t i) {
    return encoder.encode(frames[i], std::nullopt, bytes);
  });
  reportSize(state, frames.front().size());
}

void
decode(benchmark::State& state, const Variant& variant)
{
  const auto settings = compressionSettings(workloadOf(state), variant);
  io::FrameEncoder encoder = makeFrameEncoder(settings);
  std::vector<std::vector<std::uint8_t>> coded;
  for (const io::VoxelFrame& frame : voxelFrames(state, settings)) {
    coded.emplace_back();
    if (!isOk(state, encoder.encode(frame, std::nullopt, coded.back())))
      return;
  }
  io::FrameDecoder decoder;
  io::VoxelFrame decoded;
  timeInTurn(state, [&](std::size_t i) {
    return decoder.decode(coded[i].data(), coded[i].size(), decoded);
  });
  reportSize(state, decoded.size());
}

void
encodeWithClass(benchmark::State& state, const Variant& variant)
{
  std::vector<IntensityCloud::Ptr> clouds;
  for (std::uint32_t i = 0; i < frames_in_turn; ++i)
    clouds.push_back(preprocessedCloud(state, i));
  Compression compression(compressionSettings(workloadOf(state), variant));
  FrameBuffer buffer;
  std::iostream stream(&buffer);
  timeInTurn(state, [&](std::size_t i) {
    buffer.restart();
    return compression.encodePointCloud(clouds[i], stream);
  });
  reportSize(state, clouds.front()->size());
}

void
overPoints(benchmark::internal::Benchmark* benchmark)
{
  for (std::int64_t points = 1000; points <= 10000000; points *= 10)
    benchmark->Args({points, 40});
  benchmark->ArgNames({"points", "edge_mm"})
      ->Unit(benchmark::kMillisecond)
      ->Complexity(benchmark::oN);
}

void
overEdge(benchmark::internal::Benchmark* benchmark)
{
  for (const std::int64_t edge : {500, 200, 100, 50, 20, 10, 5})
    benchmark->Args({1000000, edge});
  benchmark->ArgNames({"points", "edge_mm"})->Unit(benchmark::kMillisecond);
}

/** \brief Registers a stage over both, the efforts by name. */
template <typename StageT>
void
registerStage(const std::string& name, const StageT& stage)
{
  overPoints(benchmark::RegisterBenchmark((name + "/points").c_str(), stage));
  overEdge(benchmark::RegisterBenchmark((name + "/edge").c_str(), stage));
}

void
registerAll()
{
  registerStage("preprocess", preprocess);
  registerStage("voxelize", voxelize);
  for (const Variant& variant : libraryVariants()) {
    const auto with = [&variant](void (*stage)(benchmark::State&, const Variant&)) {
      return [stage, &variant](benchmark::State& state) { stage(state, variant); };
    };
    registerStage(std::string("code/") + variant.name, with(code));
    registerStage(std::string("decode/") + variant.name, with(decode));
    registerStage(std::string("class_encode/") + variant.name, with(encodeWithClass));
  }
}

} // namespace

int
main(int argc, char** argv)
{
  registerAll();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv))
    return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
