#include "coder_comparison.h"

#include "allocation_count.h"
#include "take_turns.h"

#include <memory>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace benchmarks {

namespace {

/** \brief What a coder did with one frame; goes from its process to the parent's. */
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

/** \brief Runs an action; gives its time and its allocations. */
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
  CoderRun(const std::vector<InputFrame>& frames,
           std::unique_ptr<StreamCoder> coder,
           std::size_t error_every)
  : frames_(frames), coder_(std::move(coder)), error_every_(error_every)
  {}

  FrameFigures
  run(std::size_t index)
  {
    const InputFrame& frame = frames_[index];
    FrameFigures figures;
    measure(
        [&] { coder_->encode(frame); }, figures.encode_ms, figures.encode_allocations);
    measure([&] { coder_->decode(); }, figures.decode_ms, figures.decode_allocations);
    coder_->check(frame);
    const PositionCloud::ConstPtr decoded = coder_->decodedPositions();
    figures.points = frame.points->size();
    figures.decoded = decoded->size();
    figures.bytes = coder_->frameBytes();
    if (error_every_ != 0 && index % error_every_ == 0) {
      figures.to_decoded = nearestDistances(frame.positions, decoded);
      figures.from_decoded = nearestDistances(decoded, frame.positions);
    }
    return figures;
  }

private:
  const std::vector<InputFrame>& frames_;
  std::unique_ptr<StreamCoder> coder_;
  std::size_t error_every_;
};

void
addFrame(const FrameFigures& frame, CoderFigures& figures)
{
  figures.points.add(static_cast<double>(frame.points));
  figures.decoded.add(static_cast<double>(frame.decoded));
  figures.bytes.add(static_cast<double>(frame.bytes));
  figures.encode_ms.add(frame.encode_ms);
  figures.decode_ms.add(frame.decode_ms);
  figures.encode_allocations.add(static_cast<double>(frame.encode_allocations));
  figures.decode_allocations.add(static_cast<double>(frame.decode_allocations));
  figures.to_decoded += frame.to_decoded;
  figures.from_decoded += frame.from_decoded;
}

/** \brief Starts a coder's process; the coder itself is made there. */
ProcessOf<FrameFigures>
startCoder(const std::vector<InputFrame>& frames,
           const Workload& workload,
           const MakeCoders& make_coders,
           std::size_t which,
           const std::string& name,
           std::size_t error_every)
{
  return ProcessOf<FrameFigures>(
      name, [&frames, workload, make_coders, which, error_every] {
        StreamCoders coders = make_coders(workload);
        const auto run =
            std::make_shared<CoderRun>(frames, std::move(coders[which]), error_every);
        return [run](std::size_t index) { return run->run(index); };
      });
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
  const std::vector<InputFrame> frames =
      readFrames(stream, workload, Keep::Preprocessed);
  Comparison comparison;
  for (const auto& coder : make_coders(workload)) {
    comparison.coders.emplace_back();
    comparison.coders.back().name = coder->name();
    comparison.coders.back().content = coder->content();
  }
  const auto start = [&](std::size_t which, std::size_t error_every) {
    return startCoder(frames,
                      workload,
                      make_coders,
                      which,
                      comparison.coders[which].name,
                      error_every);
  };
  const auto add = [&comparison](std::size_t which, const FrameFigures& frame) {
    addFrame(frame, comparison.coders[which]);
  };
  for (std::size_t i = 0; i < settings.repetitions; ++i) {
    // The errors of a repetition are those of the first time.
    const std::size_t error_every = i == 0 ? settings.error_every : 0;
    std::vector<ProcessOf<FrameFigures>> processes;
    for (std::size_t which = 0; which < comparison.coders.size(); ++which) {
      processes.push_back(start(which, error_every));
      if (!settings.take_turns) {
        takeTurns(stream.clouds->name(),
                  frames.size(),
                  processes,
                  [&](std::size_t /*only*/, const FrameFigures& frame) {
                    add(which, frame);
                  });
        processes.clear();
      }
    }
    takeTurns(stream.clouds->name(), frames.size(), processes, add);
  }
  return comparison;
}

} // namespace benchmarks
} // namespace pcl_ext
