// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "meters/coder_comparison.h"

#include "meters/allocation_count.h"
#include "meters/take_turns.h"

#include <deque>
#include <functional>
#include <memory>
#include <utility>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief Figures of one frame; sent from the coder's process to the parent's. */
struct FrameFigures {
  std::size_t points = 0;
  std::size_t decoded = 0;
  std::size_t bytes = 0;
  double encode_ms = 0.0;
  double decode_ms = 0.0;
  std::size_t encode_allocations = 0;
  std::size_t decode_allocations = 0;
  NearestDistances to_decoded;
  NearestDistances from_decoded;
};

/** \brief Runs an action and measures its time and allocations. */
template <typename ActionT>
void
measure(ActionT&& action, double& milliseconds, std::size_t& allocations)
{
  const std::size_t before = allocationCount();
  milliseconds = timeOf(action);
  allocations = allocationCount() - before;
}

/** \brief One coder and its stream, in the coder's process. */
class CoderRun {
public:
  using MakeCoder = std::function<std::unique_ptr<StreamCoder>()>;

  CoderRun(const std::vector<InputFrame>& frames,
           MakeCoder make_coder,
           const ComparisonSettings& settings)
  : frames_(frames), make_coder_(std::move(make_coder)), settings_(settings)
  {}

  /** \brief Runs a frame. Frame 0 starts a new coder. */
  FrameFigures
  run(std::size_t index)
  {
    if (index == 0) {
      coder_ = make_coder_();
      ++times_begun_;
    }
    const InputFrame& frame = frames_[index];
    FrameFigures figures;
    coder_->prepare(frame);
    measure(
        [&] { coder_->encode(frame); }, figures.encode_ms, figures.encode_allocations);
    measure([&] { coder_->decode(); }, figures.decode_ms, figures.decode_allocations);
    coder_->check(frame);
    const PositionCloud::ConstPtr decoded = coder_->decodedPositions();
    figures.points = frame.points->size();
    figures.decoded = decoded->size();
    figures.bytes = coder_->frameBytes();
    // A repetition has the same errors.
    if (settings_.error_every != 0 && index % settings_.error_every == 0 &&
        times_begun_ == 1 && !decoded->empty()) {
      figures.to_decoded = nearestDistances(frame.positions, decoded);
      figures.from_decoded = nearestDistances(decoded, frame.positions);
    }
    return figures;
  }

private:
  const std::vector<InputFrame>& frames_;
  MakeCoder make_coder_;
  ComparisonSettings settings_;
  std::unique_ptr<StreamCoder> coder_;
  unsigned int times_begun_ = 0;
};

void
addFrame(std::size_t index, const FrameFigures& frame, CoderFigures& figures)
{
  figures.points.keepLeast(index, static_cast<double>(frame.points));
  figures.decoded.keepLeast(index, static_cast<double>(frame.decoded));
  figures.bytes.keepLeast(index, static_cast<double>(frame.bytes));
  figures.encode_ms.keepLeast(index, frame.encode_ms);
  figures.decode_ms.keepLeast(index, frame.decode_ms);
  figures.encode_allocations.keepLeast(index,
                                       static_cast<double>(frame.encode_allocations));
  figures.decode_allocations.keepLeast(index,
                                       static_cast<double>(frame.decode_allocations));
  figures.to_decoded += frame.to_decoded;
  figures.from_decoded += frame.from_decoded;
}

} // namespace

double
Comparison::voxels(const CoderFigures& coder) const
{
  const bool are_voxels =
      coder.content == Content::VoxelsWithIntensity || coder.content == Content::Voxels;
  return are_voxels ? coder.decoded.mean() : coders.front().decoded.mean();
}

Comparison
compareCoders(const InputStream& stream,
              const Workload& workload,
              const MakeCoders& make_coders,
              const ComparisonSettings& settings)
{
  const std::vector<InputFrame> frames = readFrames(stream, workload, settings.keep);
  Comparison comparison;
  for (const auto& coder : make_coders(workload)) {
    CoderFigures figures;
    figures.name = coder->name();
    figures.content = coder->content();
    comparison.coders.push_back(figures);
  }
  std::deque<ProcessOf<FrameFigures>> processes;
  for (std::size_t which = 0; which < comparison.coders.size(); ++which)
    processes.emplace_back(comparison.coders[which].name, [&, which] {
      const auto run = std::make_shared<CoderRun>(
          frames,
          [&, which] { return std::move(make_coders(workload)[which]); },
          settings);
      return [run](std::size_t index) { return run->run(index); };
    });
  takeTurns(stream.clouds->name(),
            frames.size(),
            settings.repetitions,
            processes,
            [&](std::size_t which, std::size_t index, const FrameFigures& frame) {
              addFrame(index, frame, comparison.coders[which]);
            });
  return comparison;
}

} // namespace measuring
} // namespace pcl_ext
