#include "filtered_stream.h"

#include "measuring/machine.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace noise {

namespace {

/** \brief Milliseconds of the processor that a call takes. */
template <typename CallT>
double
millisecondsOf(const CallT& call)
{
  const double start = measuring::threadCpuSeconds();
  call();
  return 1e3 * (measuring::threadCpuSeconds() - start);
}

/** \brief Throws unless a filter or a decoder did its work. */
template <typename StatusT>
void
require(const StatusT& status)
{
  if (!status.ok())
    throw std::runtime_error(status.message());
}

} // namespace

CodedBytes::CodedBytes(io::Effort effort, unsigned int i_frame_rate)
: name((effort == io::Effort::Fast ? "fast " : "balanced ") +
       std::to_string(i_frame_rate))
, encoder_(io::StreamFormat::Version1, i_frame_rate, effort)
{}

const std::vector<std::uint8_t>&
CodedBytes::encode(const io::VoxelFrame& frame)
{
  const bool is_i_frame = encoder_.isIFrameDue();
  require(encoder_.encode(frame, std::nullopt, bytes_));
  const auto size = static_cast<double>(bytes_.size());
  all.add(size);
  (is_i_frame ? i_frames : p_frames).add(size);
  return bytes_;
}

FilterChain::FilterChain(bool removes_outliers, bool is_temporal, Law law)
{
  if (removes_outliers) {
    VoxelOutlierRemovalSettings settings;
    settings.unit = densityUnitOf(law);
    outliers_.emplace(settings);
  }
  if (is_temporal)
    temporal_.emplace();
}

void
FilterChain::filter(io::VoxelFrame& frame, const Eigen::Vector3d& sensor_position)
{
  if (outliers_)
    require(outliers_->filter(frame));
  if (temporal_)
    require(temporal_->filter(
        frame,
        {std::array{sensor_position.x(), sensor_position.y(), sensor_position.z()},
         std::nullopt}));
}

FilteredStream::FilteredStream(std::string filter_name,
                               const std::function<FilterChain()>& chain,
                               std::int64_t first_judged)
: name(std::move(filter_name)), judge(first_judged), decoders_(repetitions)
{
  for (const auto effort : {io::Effort::Balanced, io::Effort::Fast})
    for (const unsigned int rate : {30u, 300u})
      coded.emplace_back(effort, rate);
  for (std::size_t i = 0; i < repetitions; ++i)
    chains_.push_back(chain());
}

void
FilteredStream::add(const SurfaceHistory& truth,
                    const io::VoxelFrame& measured,
                    const Eigen::Vector3d& sensor_position)
{
  double least_ms = std::numeric_limits<double>::infinity();
  for (FilterChain& chain : chains_) {
    shown_ = measured;
    least_ms = std::min(least_ms,
                        millisecondsOf([&] { chain.filter(shown_, sensor_position); }));
  }
  filter_ms.add(least_ms);
  voxels.add(static_cast<double>(shown_.size()));

  const std::vector<std::uint8_t>* bytes = nullptr;
  for (CodedBytes& one : coded)
    bytes = &one.encode(shown_);
  io::VoxelFrame decoded;
  least_ms = std::numeric_limits<double>::infinity();
  for (io::FrameDecoder& decoder : decoders_)
    least_ms =
        std::min(least_ms, millisecondsOf([&] {
                   require(decoder.decode(bytes->data(), bytes->size(), decoded));
                 }));
  decode_ms.add(least_ms);
  judge.add(truth, measured, shown_);
}

} // namespace noise
} // namespace pcl_ext
