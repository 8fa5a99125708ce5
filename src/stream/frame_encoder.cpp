#include <pcl_ext/compression/frame_encoder.h>

#include "bytes/exceptions.h"
#include "codec/history_use.h"
#include "codec/payload_coder.h"
#include "codec/published/frame.h"
#include "codec/supplement/coarse_voxels.h"
#include "codec/supplement/supplement.h"
#include "stream/version1_header.h"
#include "voxels/ascending_keys.h"
#include "voxels/grid_fit.h"
#include "voxels/memory_rule.h"

#include <algorithm>
#include <numeric>

namespace pcl_ext {
namespace io {

class FrameEncoder::Implementation {
public:
  Implementation(StreamFormat format, unsigned int i_frame_rate, Effort effort)
  : format_(format)
  , effort_(effort == Effort::Fast || effort == Effort::Small ? effort
                                                              : Effort::Balanced)
  , i_frame_rate_(std::max(i_frame_rate, 1u))
  {}

  bool
  isIFrameDue() const
  {
    return is_i_frame_requested_ || frames_since_i_frame_ >= i_frame_rate_;
  }

  void
  requestIFrame()
  {
    is_i_frame_requested_ = true;
  }

  CompressionStatus
  encode(const VoxelFrame& frame,
         const std::optional<FrameStamp>& stamp,
         std::vector<std::uint8_t>& bytes)
  {
    const auto encode = [&] {
      bytes.clear();
      CompressionStatus status = check(frame, stamp);
      if (status.ok())
        encodeFrame(frame, stamp, bytes);
      return status;
    };
    // If memory runs out the state of the coders is undefined.
    const auto out_of_memory = [&] {
      bytes.clear();
      coders_.clear();
      supplement_.reset();
      requestIFrame();
      return outOfMemoryStatus<CompressionStatus>();
    };
    CompressionStatus status = callOrElse(encode, out_of_memory);
    if (status.ok())
      followStream(frame);
    return status;
  }

  const CodedFrameStatistics&
  statistics() const
  {
    return statistics_;
  }

private:
  CompressionStatus
  check(const VoxelFrame& frame, const std::optional<FrameStamp>& stamp) const
  {
    if (!isConsistent(frame))
      return {CompressionCode::InvalidInput,
              "the voxel frame is inconsistent: keys must ascend within the grid, with "
              "one intensity symbol within the scale for each, and so for colours and "
              "numbers of points where it has them"};
    if (format_ == StreamFormat::Published) {
      if (stamp)
        return {CompressionCode::InvalidInput,
                "the published layout has no fields for stamp and frame_id"};
      if (frame.intensity_scale != IntensityScale())
        return {CompressionCode::InvalidInput,
                "in the published layout intensities must be 0 to 255 in steps of 1"};
      if (frame.colour_bits > 0 || frame.has_point_counts)
        return {CompressionCode::InvalidInput,
                "the published layout has no fields for colours and numbers of points"};
    }
    else if (!isOrigin(frame.grid.origin) || leavesLattice(frame.grid))
      return {CompressionCode::InvalidInput,
              "in stream version 1 the grid must be within 2^20 voxels of its origin"};
    if (frame.size() > largest_frame)
      return {CompressionCode::InvalidInput,
              "the frame has " + std::to_string(frame.size()) +
                  " voxels; at most 2^24 are supported"};
    if (stamp && stamp->frame_id.size() > max_frame_id_size)
      return {CompressionCode::InvalidInput,
              "frame_id has " + std::to_string(stamp->frame_id.size()) +
                  " bytes; at most " + std::to_string(max_frame_id_size) +
                  " are supported"};
    return {};
  }

  void
  encodeFrame(const VoxelFrame& frame,
              const std::optional<FrameStamp>& stamp,
              std::vector<std::uint8_t>& bytes)
  {
    CodedFrameStatistics statistics;
    statistics.voxels = frame.size();
    statistics.is_i_frame = isIFrameDue();
    if (format_ == StreamFormat::Published) {
      // PCL's empty octree loses its depth, so that a frame without voxels and the frame
      // after it are I-frames, as in the authors' encoder.
      statistics.is_i_frame |=
          frame.grid != published_.grid || frame.keys.empty() || is_last_empty_;
      published::encodeFrame(
          frame, statistics.is_i_frame, published_, bytes, statistics);
    }
    else {
      statistics.is_i_frame = statistics.is_i_frame || needsIFrame(frame, stamp);
      encodeVersion1(frame, stamp, bytes, statistics);
    }
    is_last_empty_ = frame.keys.empty();
    is_i_frame_requested_ = false;
    if (format_ == StreamFormat::Version1 && !coder().choosesHistory())
      followHistory(frame, stamp, bytes, statistics);
    frames_since_i_frame_ = statistics.is_i_frame ? 1 : frames_since_i_frame_ + 1;
    statistics_ = statistics;
  }

  /** \brief With a coder whose P-frames always use the history: replaces a P-frame that takes
   * more bytes than an I-frame, and requests I-frames where it would be so again. */
  void
  followHistory(const VoxelFrame& frame,
                const std::optional<FrameStamp>& stamp,
                std::vector<std::uint8_t>& bytes,
                CodedFrameStatistics& statistics)
  {
    const bool was_tried =
        !statistics.is_i_frame && history_use_.isDoubtful(statistics.voxels,
                                                          statistics.bytes,
                                                          frame.has_point_counts);
    if (was_tried) {
      bytes.clear();
      --frame_number_;
      statistics.is_i_frame = true;
      encodeVersion1(frame, stamp, bytes, statistics);
    }
    if (statistics.is_i_frame) {
      history_use_.measure(statistics.voxels, statistics.bytes);
      history_use_.addWithout(was_tried);
    }
    else if (statistics.voxels > 0)
      history_use_.addWith();
    is_i_frame_requested_ = !history_use_.isUseful();
  }

  /** \brief Releases memory that recent frames did not need. */
  void
  followStream(const VoxelFrame& frame)
  {
    const std::size_t needed =
        frame.size() + bytes_of_payload_.size() + coders_.trackedVoxels(effort_);
    work_.endFrame(needed, needed);
    if (!memory_rule_.shouldRelease(needed))
      return;
    bytes_of_payload_ = std::vector<std::uint8_t>();
    coarse_voxels_ = VoxelFrame();
    last_keys_ = std::vector<std::uint64_t>();
    if (supplement_)
      supplement_->releaseMemory();
    frame_without_model_ = VoxelFrame();
    if (format_ == StreamFormat::Version1)
      // Without memory for smaller copies the memory stays as it is.
      callOrElse([this] { coder().releaseMemory(); }, [] {});
  }

  /** \brief True if a frame cannot be a P-frame, or should be none. If false, it is matched
   * with the history. */
  bool
  needsIFrame(const VoxelFrame& frame, const std::optional<FrameStamp>& stamp)
  {
    if (frame.grid != grid_ || frame.intensity_scale != intensity_scale_ ||
        frame.depth_model.has_value() != has_depth_model_ ||
        frame.colour_bits != content_.colour_bits ||
        frame.has_point_counts != content_.has_point_counts)
      return true;
    // A large change of the stamp, as of the first one in a stream, takes more bytes in a
    // P-frame's header than the stamp itself.
    constexpr std::int64_t far = std::int64_t{1} << 27;
    if (stamp && (stampChange(*stamp) >= far || stampChange(*stamp) < -far))
      return true;
    // A moving sensor leaves many records, which take time and memory in both directions.
    if (coder().trackedVoxels() > maxTrackedVoxels(frame.size()))
      return true;
    if (content_.refinement_levels > 0 && comeAgain(frame.keys)) {
      is_refinement_useful_ = false;
      return true;
    }
    // The result of match() is used by encode().
    const VoxelFrame& coded = codedVoxels(frame);
    const std::size_t known = coder().match(work_, coded);
    if (content_.refinement_levels == 0)
      is_refinement_useful_ = 4 * known < coded.size();
    return false;
  }

  /** \brief True if half of the voxels were in the last frame, too: then a history of them
   * is worth more than a refinement. */
  bool
  comeAgain(const std::vector<std::uint64_t>& keys) const
  {
    std::size_t known = 0;
    AscendingLookup<std::uint64_t> lookup(last_keys_);
    for (const std::uint64_t key : keys)
      known += lookup.find(key) != not_in_list ? 1 : 0;
    return !keys.empty() && 2 * known >= keys.size();
  }

  /** \brief What the coder of voxels codes: with a refinement the coarse voxels. */
  const VoxelFrame&
  codedVoxels(const VoxelFrame& frame)
  {
    if (content_.refinement_levels == 0)
      return frame;
    coarse_voxels_.grid = frame.grid;
    coarse_voxels_.grid.depth -= content_.refinement_levels;
    coarse_voxels_.intensity_scale.bits = 0;
    supplement::coarseVoxelsOf(
        frame.keys, content_.refinement_levels, coarse_voxels_.keys);
    return coarse_voxels_;
  }

  PayloadCoder&
  coder()
  {
    return coders_.of(effort_);
  }

  /** \brief Change of the stamp since the last frame, modulo 2^64. */
  std::int64_t
  stampChange(const FrameStamp& stamp) const
  {
    return static_cast<std::int64_t>(stamp.stamp - stamp_);
  }

  void
  encodeVersion1(const VoxelFrame& frame,
                 const std::optional<FrameStamp>& stamp,
                 std::vector<std::uint8_t>& bytes,
                 CodedFrameStatistics& statistics)
  {
    Version1Header& header = header_;
    header.is_i_frame = statistics.is_i_frame;
    header.effort = effort_;
    header.frame_number = frame_number_ + 1;
    header.grid = frame.grid;
    header.intensity_scale = frame.intensity_scale;
    if (header.is_i_frame) {
      // As the decoder does.
      frame_id_.clear();
      stamp_ = 0;
    }
    header.stamp.reset();
    header.has_frame_id = stamp && (header.is_i_frame || stamp->frame_id != frame_id_);
    header.frame_id.clear();
    if (stamp) {
      header.stamp = stampChange(*stamp);
      if (header.has_frame_id)
        header.frame_id = stamp->frame_id;
      frame_id_ = stamp->frame_id;
      stamp_ = stamp->stamp;
    }
    if (header.is_i_frame)
      chooseContent(frame);
    header.content = content_;
    header.voxel_count = frame.size();
    const VoxelFrame& coded = codedVoxels(frame);
    header.coarse_voxel_count = coded.size();
    PayloadSizes sizes = encodePayload(coded, header);
    const std::size_t supplement_begin = bytes_of_payload_.size();
    encodeSupplement(frame, coded, header, sizes);
    header.supplement_size = bytes_of_payload_.size() - supplement_begin;
    header.payload_size = bytes_of_payload_.size();
    checksum_ = writeVersion1Frame(
        header, bytes_of_payload_, header.is_i_frame ? 0 : checksum_, bytes);

    frame_number_ = header.frame_number;
    statistics.frame_number = frame_number_;
    statistics.bytes = bytes.size();
    statistics.header_bytes = bytes.size() - bytes_of_payload_.size();
    statistics.occupancy_bytes = sizes.occupancy;
    statistics.attribute_bytes = sizes.attributes;
    statistics.intensity_bytes =
        bytes_of_payload_.size() - sizes.occupancy - sizes.attributes;
    grid_ = frame.grid;
    intensity_scale_ = frame.intensity_scale;
    has_depth_model_ = frame.depth_model.has_value();
  }

  /** \brief Chooses what is in the supplements until the next I-frame. */
  void
  chooseContent(const VoxelFrame& frame)
  {
    content_.colour_bits = frame.colour_bits;
    content_.has_point_counts = frame.has_point_counts;
    content_.refinement_levels =
        is_refinement_useful_ ? supplement::chooseRefinement(frame) : 0;
  }

  /** \brief Appends the supplement to the payload, if the content has one. */
  void
  encodeSupplement(const VoxelFrame& frame,
                   const VoxelFrame& coarse_voxels,
                   Version1Header& header,
                   PayloadSizes& sizes)
  {
    header.point_count = std::accumulate(
        frame.point_counts.begin(), frame.point_counts.end(), std::uint64_t{0});
    if (content_.refinement_levels > 0 && i_frame_rate_ > 1)
      last_keys_.assign(frame.keys.begin(), frame.keys.end());
    if (!content_.hasSupplement() || frame.keys.empty()) {
      if (supplement_ && header.is_i_frame)
        supplement_->reset();
      return;
    }
    if (!supplement_)
      supplement_ = std::make_unique<supplement::SupplementCoder>();
    const supplement::Sizes added = supplement_->encode(
        {content_, coarse_voxels.keys, effort_, header.is_i_frame, frame.size()},
        frame,
        bytes_of_payload_);
    sizes.occupancy += added.refinement;
    sizes.attributes += added.attributes;
  }

  /** \brief Encodes the payload. An I-frame with a depth model is encoded with and without
   * it, as the model does not help if most symbols are saturated. The smaller variant is
   * used until the next I-frame. */
  PayloadSizes
  encodePayload(const VoxelFrame& frame, Version1Header& header)
  {
    if (!frame.depth_model)
      return encodePayloadAs(frame, header);
    if (header.is_i_frame || !uses_depth_model_) {
      frame_without_model_.grid = frame.grid;
      frame_without_model_.intensity_scale = frame.intensity_scale;
      frame_without_model_.keys = frame.keys;
      frame_without_model_.intensities = frame.intensities;
      frame_without_model_.has_point_counts = frame.has_point_counts;
      frame_without_model_.point_counts = frame.point_counts;
    }
    if (!header.is_i_frame)
      return encodePayloadAs(uses_depth_model_ ? frame : frame_without_model_, header);
    encodePayloadAs(frame_without_model_, header);
    const std::size_t size_without = bytes_of_payload_.size();
    const PayloadSizes sizes = encodePayloadAs(frame, header);
    uses_depth_model_ = frame.keys.empty() || bytes_of_payload_.size() <= size_without;
    return uses_depth_model_ ? sizes : encodePayloadAs(frame_without_model_, header);
  }

  PayloadSizes
  encodePayloadAs(const VoxelFrame& frame, Version1Header& header)
  {
    if (header.is_i_frame)
      depth_model_.reset();
    bytes_of_payload_.clear();
    header.has_depth_model = frame.depth_model != depth_model_;
    if (header.has_depth_model)
      writeDepthModel(*frame.depth_model, bytes_of_payload_);
    depth_model_ = frame.depth_model;
    return coder().encode(work_, frame, header.is_i_frame, bytes_of_payload_);
  }

  StreamFormat format_;
  Effort effort_;
  std::uint32_t i_frame_rate_;
  std::uint32_t frames_since_i_frame_ = 0;
  bool is_i_frame_requested_ = true;
  bool is_last_empty_ = false;
  CodedFrameStatistics statistics_;

  published::History published_;

  // Version 1: state after the previous frames.
  std::uint32_t frame_number_ = 0;
  std::uint32_t checksum_ = 0;
  VoxelGrid grid_;
  IntensityScale intensity_scale_;
  bool has_depth_model_ = false;          // the previous frame
  bool uses_depth_model_ = false;         // encodePayload() since the last I-frame
  std::optional<DepthModel> depth_model_; // that a decoder has
  VoxelFrame frame_without_model_;        // member so that its memory is reused
  supplement::Content content_;
  bool is_refinement_useful_ = true;                        // by the previous frames
  std::vector<std::uint64_t> last_keys_;                    // with a refinement
  std::unique_ptr<supplement::SupplementCoder> supplement_; // made when it is needed
  std::string frame_id_;
  std::uint64_t stamp_ = 0;
  PayloadCoders coders_;
  HistoryUse history_use_;
  // Of the current frame; members so that their memory is reused.
  Version1Header header_;
  VoxelFrame coarse_voxels_;
  std::vector<std::uint8_t> bytes_of_payload_;
  CodingWorkspace work_;
  MemoryRule memory_rule_;
};

FrameEncoder::FrameEncoder(StreamFormat format,
                           unsigned int i_frame_rate,
                           Effort effort)
: implementation_(std::make_unique<Implementation>(format, i_frame_rate, effort))
{}

FrameEncoder::~FrameEncoder() = default;
FrameEncoder::FrameEncoder(FrameEncoder&&) noexcept = default;
FrameEncoder&
FrameEncoder::operator=(FrameEncoder&&) noexcept = default;

bool
FrameEncoder::isIFrameDue() const
{
  return implementation_->isIFrameDue();
}

void
FrameEncoder::requestIFrame()
{
  implementation_->requestIFrame();
}

CompressionStatus
FrameEncoder::encode(const VoxelFrame& frame,
                     const std::optional<FrameStamp>& stamp,
                     std::vector<std::uint8_t>& bytes)
{
  return implementation_->encode(frame, stamp, bytes);
}

const CodedFrameStatistics&
FrameEncoder::statistics() const
{
  return implementation_->statistics();
}

} // namespace io
} // namespace pcl_ext
