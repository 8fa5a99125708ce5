#include <pcl_ext/compression/frame_encoder.h>

#include "grid_fit.h"
#include "occupancy_tree.h"
#include "published_frame.h"
#include "version1_header.h"
#include "version1_payload.h"

#include <algorithm>

namespace pcl_ext {
namespace io {

class FrameEncoder::Implementation {
public:
  Implementation(StreamFormat format, unsigned int i_frame_rate)
  : format_(format), i_frame_rate_(std::max(i_frame_rate, 1u))
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
    bytes.clear();
    if (CompressionStatus status = check(frame, stamp); !status.ok())
      return status;
    const VoxelGrid& last_grid =
        format_ == StreamFormat::Published ? published_.grid : grid_;
    statistics_ = CodedFrameStatistics();
    statistics_.voxels = frame.size();
    statistics_.is_i_frame = isIFrameDue() || frame.grid != last_grid;
    if (format_ == StreamFormat::Published) {
      // PCL's empty octree forgets its depth, so a frame without voxels stands alone
      // and so does the frame behind it; the authors' encoder restarts there, too.
      statistics_.is_i_frame |= frame.keys.empty() || is_last_empty_;
      encodePublished(frame, statistics_.is_i_frame, published_, bytes, statistics_);
    }
    else
      encodeVersion1(frame, stamp, bytes);
    is_last_empty_ = frame.keys.empty();
    is_i_frame_requested_ = false;
    frames_since_i_frame_ = statistics_.is_i_frame ? 1 : frames_since_i_frame_ + 1;
    return {};
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
              "one intensity symbol within the scale for each"};
    if (format_ == StreamFormat::Published) {
      if (stamp)
        return {CompressionCode::InvalidInput,
                "the published layout carries no cloud header"};
      if (frame.intensity_scale != IntensityScale())
        return {CompressionCode::InvalidInput,
                "the published layout has intensities of 0 to 255 in steps of 1"};
    }
    else if (frame.grid.anchor != VoxelGrid().anchor || leavesLattice(frame.grid))
      return {CompressionCode::InvalidInput,
              "stream version 1 has a grid anchored at the world origin, within 2^20 "
              "voxels of it"};
    if (stamp && stamp->frame_id.size() > max_frame_id_size)
      return {CompressionCode::InvalidInput,
              "a frame_id of " + std::to_string(stamp->frame_id.size()) +
                  " bytes is longer than " + std::to_string(max_frame_id_size)};
    return {};
  }

  void
  encodeVersion1(const VoxelFrame& frame,
                 const std::optional<FrameStamp>& stamp,
                 std::vector<std::uint8_t>& bytes)
  {
    OccupancyTree tree;
    tree.build(frame.keys, frame.grid.depth);
    std::vector<std::uint8_t> payload;
    if (!frame.keys.empty())
      encodeOccupancy(tree, statistics_.is_i_frame ? nullptr : &tree_, payload);
    statistics_.occupancy_bytes = payload.size();
    if (!frame.keys.empty())
      encodeIntensities(frame.intensities, frame.intensity_scale.bits, payload);
    statistics_.intensity_bytes = payload.size() - statistics_.occupancy_bytes;

    Version1Header header;
    header.is_i_frame = statistics_.is_i_frame;
    header.frame_number = ++frame_number_;
    header.reference_distance = header.is_i_frame ? 0 : 1;
    header.grid = frame.grid;
    if (header.is_i_frame || frame.intensity_scale != intensity_scale_)
      header.intensity_scale = frame.intensity_scale;
    if (header.is_i_frame)
      frame_id_.clear(); // as the decoder does
    if (stamp) {
      header.stamp = stamp->stamp;
      if (header.is_i_frame || stamp->frame_id != frame_id_)
        header.frame_id = stamp->frame_id;
      frame_id_ = stamp->frame_id;
    }
    header.voxel_count = frame.size();
    header.occupancy_size = statistics_.occupancy_bytes;
    header.intensity_size = statistics_.intensity_bytes;
    checksum_ =
        writeVersion1Frame(header, payload, header.is_i_frame ? 0 : checksum_, bytes);

    statistics_.frame_number = frame_number_;
    statistics_.bytes = bytes.size();
    statistics_.header_bytes = bytes.size() - payload.size();
    grid_ = frame.grid;
    intensity_scale_ = frame.intensity_scale;
    tree_ = std::move(tree);
  }

  StreamFormat format_;
  std::uint32_t i_frame_rate_;
  std::uint32_t frames_since_i_frame_ = 0;
  bool is_i_frame_requested_ = true;
  bool is_last_empty_ = false;
  CodedFrameStatistics statistics_;

  PublishedHistory published_;

  // History of version 1: the last frame.
  std::uint32_t frame_number_ = 0;
  std::uint32_t checksum_ = 0;
  VoxelGrid grid_;
  IntensityScale intensity_scale_;
  std::string frame_id_;
  OccupancyTree tree_;
};

FrameEncoder::FrameEncoder(StreamFormat format, unsigned int i_frame_rate)
: implementation_(std::make_unique<Implementation>(format, i_frame_rate))
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
