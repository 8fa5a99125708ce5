#include "meters/coder_growth.h"

#include "inputs/sampled_room.h"
#include "measuring/machine.h"
#include "measuring/samples.h"
#include "meters/allocation_count.h"
#include "meters/take_turns.h"

#include <malloc.h>

#include <algorithm>
#include <vector>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief Clouds that the frames of a period alternate between. */
constexpr std::size_t cloud_count = 2;

/** \brief Adds up what the calls of an encoder or of a decoder take. */
class CallMeter {
public:
  /** \param[in] warm_up number of calls of which only memory counts */
  explicit CallMeter(std::size_t warm_up) : warm_up_(warm_up) {}

  /** \param[in] frame number of the call */
  template <typename ActionT>
  void
  measure(std::size_t frame, ActionT&& call)
  {
    restartPeakResident();
    const double before = residentMegabytes();
    const std::size_t allocations_before = allocationCount();
    const double milliseconds = timeOf(call);
    const std::size_t allocations = allocationCount() - allocations_before;
    figures_.megabytes =
        std::max(figures_.megabytes, held_ + peakResidentMegabytes() - before);
    held_ += residentMegabytes() - before;
    if (frame >= warm_up_) {
      milliseconds_.keepLeast(frame - warm_up_, milliseconds);
      figures_.allocations = std::max(figures_.allocations, allocations);
    }
  }

  CallFigures
  figures() const
  {
    CallFigures figures = figures_;
    figures.milliseconds = milliseconds_.median();
    return figures;
  }

private:
  std::size_t warm_up_;
  CallFigures figures_;
  Samples milliseconds_;
  double held_ = 0.0; // megabytes that remain between the calls
};

GrowthFigures
measureHere(StreamCoder& coder,
            const std::vector<InputFrame>& clouds,
            const GrowthStream& stream)
{
  const std::size_t period = stream.workload.i_frame_rate;
  const std::size_t warm_up = period * warm_up_periods;
  CallMeter encoding(warm_up);
  CallMeter decoding(warm_up);
  GrowthFigures figures;
  figures.frames = period * stream.periods - warm_up;
  // What was freed would be taken again without being seen.
  malloc_trim(0);
  for (std::size_t i = 0; i < period * stream.periods; ++i) {
    const InputFrame& cloud = clouds[i % period % clouds.size()];
    encoding.measure(i, [&] { coder.encode(cloud); });
    decoding.measure(i, [&] { coder.decode(); });
    if (i + 1 == period * stream.periods)
      coder.check(cloud);
  }
  figures.voxels = coder.decodedPositions()->size();
  figures.encode = encoding.figures();
  figures.decode = decoding.figures();
  return figures;
}

} // namespace

GrowthFigures
measureCoder(const std::string& name,
             const std::function<std::unique_ptr<StreamCoder>()>& make_coder,
             const GrowthStream& stream)
{
  ProcessOf<GrowthFigures> process(name, [&stream, &make_coder] {
    return [&stream, &make_coder](std::size_t /*frame*/) {
      const std::vector<InputFrame> clouds =
          readFrames(openRoomStream(stream.points, cloud_count),
                     stream.workload,
                     Keep::Preprocessed);
      return measureHere(*make_coder(), clouds, stream);
    };
  });
  return process.measure(0);
}

} // namespace measuring
} // namespace pcl_ext
