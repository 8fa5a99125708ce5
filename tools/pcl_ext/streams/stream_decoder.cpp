#include "streams/stream_decoder.h"

#include "inputs/stream_metadata.h"
#include "options/text_values.h"

#include <algorithm>
#include <utility>

namespace pcl_ext {
namespace tools {

std::string
reasonOf(const io::CompressionStatus& status)
{
  if (status.code() == io::CompressionCode::MissingReference)
    return "it needs a frame before it that is missing or was not decoded; decoding "
           "goes "
           "on with the next I-frame";
  std::string reason = status.message();
  const std::string number = " of frame ";
  if (const std::size_t begin = reason.find(number); begin != std::string::npos) {
    const std::size_t end =
        reason.find_first_not_of("0123456789", begin + number.size());
    reason.erase(begin, std::min(end, reason.size()) - begin);
  }
  return reason;
}

StreamDecoder::StreamDecoder(recording::RecordingReader& reader,
                             std::size_t stream,
                             const std::string& name,
                             const DecodingOptions& options)
: decoder_(reader, stream, options.limits)
, name_(name)
, min_intensity_(options.min_intensity)
{
  if (!options.removes_outliers)
    return;
  VoxelOutlierRemovalSettings settings;
  settings.unit = options.unit;
  const std::optional<IntensityLaw> law = lawOf(reader.streams()[stream].metadata);
  if (settings.unit == DensityUnit::Automatic && law) {
    settings.unit = densityUnitOf(*law);
    knows_densities_ = settings.unit != DensityUnit::Voxels;
  }
  else if (settings.unit == DensityUnit::Automatic)
    remark_ = name_ +
              ": the recording does not tell what its intensities are; of counts "
              "of a depth camera --unit points removes more outliers";
  removal_.emplace(settings);
}

io::CompressionStatus
StreamDecoder::decode(const recording::RecordedFrame& frame)
{
  io::CompressionStatus status = decoder_.decode(frame, voxels_);
  if (!status.ok())
    return status;
  decoded_voxels_ = voxels_.size();
  if (removal_) {
    const OutlierRemovalStatus removed = removal_->filter(voxels_);
    knows_densities_ &= voxels_.intensity_scale.bits > 0;
    judged_ += removed.ok() ? decoded_voxels_ : 0;
    removed_ += removed.removed;
    if (!removed.ok() && !std::exchange(outliers_stay_, true))
      remark_ = name_ + ", frame " + std::to_string(frame.number) +
                ": outliers stay: " + removed.message();
  }
  if (min_intensity_)
    removeVoxelsBelow(voxels_, *min_intensity_);
  return status;
}

std::string
StreamDecoder::remark() const
{
  constexpr std::size_t hardly_any = 1000; // one of so many
  if (outliers_stay_ || knows_densities_)
    return remark_;
  if (hardly_any * removed_ >= judged_)
    return {};
  return name_ + ": " + counted(removed_, "voxel") + " of " +
         counted(judged_, "voxel") +
         " left out: the recording does not tell how many points a voxel had, so that "
         "only voxels that are seldom occupied are noise; it does where it was encoded "
         "with --law count or --law quadratic";
}

} // namespace tools
} // namespace pcl_ext
