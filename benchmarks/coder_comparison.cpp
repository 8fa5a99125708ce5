#include "coder_comparison.h"

#include "allocation_count.h"

#include <stdexcept>

namespace pcl_ext {
namespace benchmarks {

namespace {

/** \brief Runs an action, and adds its time and its allocations to the samples. */
template <typename ActionT>
void
measure(ActionT&& action, Samples& milliseconds, Samples& allocations)
{
  const std::size_t before = allocationCount();
  const double time = timeOf(action);
  allocations.add(static_cast<double>(allocationCount() - before));
  milliseconds.add(time);
}

void
runFrame(StreamCoder& coder, const InputFrame& frame, CoderFigures& figures)
{
  measure([&] { coder.encode(frame); }, figures.encode_ms, figures.encode_allocations);
  measure([&] { coder.decode(); }, figures.decode_ms, figures.decode_allocations);
  coder.check(frame);
  figures.bytes.add(static_cast<double>(coder.frameBytes()));
}

void
addErrors(const StreamCoder& coder, const InputFrame& frame, CoderFigures& figures)
{
  figures.to_decoded += nearestDistances(frame.positions, coder.decodedPositions());
  figures.from_decoded += nearestDistances(coder.decodedPositions(), frame.positions);
}

void
runStream(const InputStream& stream,
          const Workload& workload,
          StreamCoders& coders,
          std::size_t error_every,
          Comparison& comparison)
{
  FrameReader reader(stream, workload);
  InputFrame frame;
  for (std::size_t index = 0; index < stream.clouds->size(); ++index) {
    reader.read(index, frame);
    comparison.points.add(static_cast<double>(frame.points->size()));
    for (std::size_t turn = 0; turn < coders.size(); ++turn) {
      const std::size_t which = (index + turn) % coders.size();
      StreamCoder& coder = *coders[which];
      try {
        runFrame(coder, frame, comparison.coders[which]);
      }
      catch (const std::exception& error) {
        throw std::runtime_error(stream.clouds->name() + ", frame " +
                                 std::to_string(index) + ", " + coder.name() + ": " +
                                 error.what());
      }
      if (error_every != 0 && index % error_every == 0)
        addErrors(coder, frame, comparison.coders[which]);
    }
    const std::size_t reference = coders.front()->decodedPositions()->size();
    for (std::size_t i = 0; i < coders.size(); ++i) {
      const Content content = coders[i]->content();
      const bool are_voxels =
          content == Content::VoxelsWithIntensity || content == Content::Voxels;
      comparison.coders[i].voxels.add(static_cast<double>(
          are_voxels ? coders[i]->decodedPositions()->size() : reference));
    }
  }
}

} // namespace

Comparison
compareCoders(const InputStream& stream,
              const Workload& workload,
              const MakeCoders& make_coders,
              const ComparisonSettings& settings)
{
  Comparison comparison;
  for (std::size_t i = 0; i < settings.repetitions; ++i) {
    StreamCoders coders = make_coders(workload);
    if (comparison.coders.empty())
      for (const auto& coder : coders) {
        comparison.coders.emplace_back();
        comparison.coders.back().name = coder->name();
        comparison.coders.back().content = coder->content();
      }
    runStream(stream, workload, coders, i == 0 ? settings.error_every : 0, comparison);
  }
  return comparison;
}

} // namespace benchmarks
} // namespace pcl_ext
