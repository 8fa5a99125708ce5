// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/version1_encoder.h"

#include "bytes/byte_writer.h"
#include "bytes/exceptions.h"
#include "codec/frame_limits.h"
#include "codec/supplement/coarse_voxels.h"
#include "stream/image_table.h"
#include "stream/image_trial.h"
#include "voxels/ascending_keys.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <numeric>

namespace pcl_ext {
namespace io {

namespace {

/** \brief I-frames behind a trial that are not tried. */
constexpr unsigned int settled_i_frames = 15;
/** \brief What takes more than so many times the bytes of a point is not alike. */
constexpr double near = 1.25;

} // namespace

Version1Encoder::Version1Encoder(Effort effort, bool has_p_frames)
: effort_(effort), has_p_frames_(has_p_frames)
{}

Version1Encoder::~Version1Encoder() = default;

bool
Version1Encoder::needsIFrame(const VoxelFrame& frame,
                             const std::optional<FrameStamp>& stamp)
{
  if (frame.grid != grid_ || frame.intensity_scale != intensity_scale_ ||
      frame.depth_model.has_value() != has_depth_model_ ||
      frame.colour_bits != content_.colour_bits ||
      frame.has_point_counts != content_.has_point_counts || hasOtherFields(frame) ||
      hasOtherImage(frame))
    return true;
  // A large change of the stamp, as of the first one in a stream, takes more bytes in a
  // P-frame's header than the stamp itself.
  constexpr std::int64_t far = std::int64_t{1} << 27;
  if (stamp && (stampChange(*stamp) >= far || stampChange(*stamp) < -far))
    return true;
  // A moving sensor leaves many records, which take time and memory in both directions.
  if (coder().trackedVoxels() > maxTracked(frame.size()) ||
      coder().trackedBlocks() > maxTracked(countBlocks(frame.keys)) ||
      !fitsHistory(coder().trackedBlocks(), frame.size()))
    return true;
  if (content_.refinement_levels > 0 && comeAgain(frame.keys)) {
    is_refinement_useful_ = false;
    return true;
  }
  return false;
}

const VoxelFrame&
Version1Encoder::match(const VoxelFrame& frame)
{
  const VoxelFrame& coded = codedVoxels(frame);
  const std::size_t tracked = coder().match(work_, coded);
  if (!content_.hasVoxels())
    is_refinement_useful_ = 4 * tracked < coded.size();
  return coded;
}

bool
Version1Encoder::hasFewChanges(const VoxelFrame& frame, bool was_of_changes)
{
  // Smaller ones take few bytes and little time anyway.
  constexpr std::size_t least_voxels = 1024;
  // To begin with them takes fewer than to go on, as they leave the history behind.
  // The other efforts code many changes in fewer bytes with their history.
  const std::size_t share =
      (was_of_changes ? 4 : 8) * (effort_ == Effort::Fast ? 1 : 2);
  const std::size_t most_changes = frame.size() / share;
  return frame.size() >= least_voxels && mayBeFollowedByChanges() &&
         (!uses_depth_model_ || frame.depth_model == depth_model_) &&
         changes_->blockCount() <= maxTracked(frame.size()) &&
         changes_->countChanges(work_, frame) <= most_changes;
}

void
Version1Encoder::encodeChanges(const VoxelFrame& frame,
                               const std::optional<FrameStamp>& stamp,
                               std::vector<std::uint8_t>& bytes,
                               CodedFrameStatistics& statistics)
{
  writeHeader(frame, false, stamp);
  header_.is_of_changes = true;
  header_.has_depth_model = false;
  payload_.clear();
  changes_->encode(work_, frame, payload_);
  writeFrame(frame, {payload_.size(), 0, 0}, bytes, statistics);
}

bool
Version1Encoder::hasOtherFields(const VoxelFrame& frame) const
{
  return !std::equal(frame.fields.begin(),
                     frame.fields.end(),
                     fields_.begin(),
                     fields_.end(),
                     [](const FieldDescription& one, const FieldDescription& other) {
                       return one == other;
                     });
}

/** \brief True if the points do not have the order of the last frame and its rays, in
 * any pose, which was coded with these, or may have those of the first one with
 * points. */
bool
Version1Encoder::hasOtherImage(const VoxelFrame& frame) const
{
  if (is_i_frame_empty_ && !content_.has_image)
    return frame.image.hasPixels() && !frame.keys.empty();
  return content_.has_image &&
         (frame.image.width != image_.width || frame.image.height != image_.height ||
          frame.image.is_organised != image_.is_organised ||
          frame.image.has_points_at_sensor != image_.has_points_at_sensor ||
          !frame.image.rays.isSameButForPose(image_.rays));
}

/** \brief True if half of the voxels were in the last frame, too: then a history of
 * them is worth more than a refinement. */
bool
Version1Encoder::comeAgain(const std::vector<std::uint64_t>& keys) const
{
  std::size_t repeated = 0;
  AscendingLookup<std::uint64_t> lookup(last_keys_);
  for (const std::uint64_t key : keys)
    repeated += lookup.find(key) != not_in_list ? 1 : 0;
  return !keys.empty() && 2 * repeated >= keys.size();
}

/** \brief What the coder of voxels codes: with a refinement the coarse voxels, with an
 * image nothing. */
const VoxelFrame&
Version1Encoder::codedVoxels(const VoxelFrame& frame)
{
  if (!content_.hasVoxels())
    return frame;
  coarse_voxels_.keys.clear();
  coarse_voxels_.grid = frame.grid;
  coarse_voxels_.grid.depth -= content_.refinement_levels;
  coarse_voxels_.intensity_scale.bits = 0;
  if (!content_.has_image)
    supplement::coarseVoxelsOf(
        frame.keys, content_.refinement_levels, coarse_voxels_.keys);
  return coarse_voxels_;
}

/** \brief Sets what the header has of the frame, the stamp and the stream. */
void
Version1Encoder::writeHeader(const VoxelFrame& frame,
                             bool is_i_frame,
                             const std::optional<FrameStamp>& stamp)
{
  Version1Header& header = header_;
  header.is_i_frame = is_i_frame;
  header.is_of_changes = false;
  header.effort = effort_;
  header.frame_number = frame_number_ + 1;
  header.grid = frame.grid;
  header.intensity_scale = frame.intensity_scale;
  header.ray_pose.reset();
  if (!is_i_frame && content_.has_image && frame.image.rays.pose != image_.rays.pose)
    header.ray_pose = image_.rays.pose = frame.image.rays.pose;
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
}

void
Version1Encoder::encode(const VoxelFrame& frame,
                        const VoxelFrame* matched,
                        const std::optional<FrameStamp>& stamp,
                        std::vector<std::uint8_t>& bytes,
                        CodedFrameStatistics& statistics)
{
  const bool is_i_frame = matched == nullptr;
  const bool had_image = content_.has_image;
  wants_i_frame_ = false;
  writeHeader(frame, is_i_frame, stamp);
  const PayloadSizes sizes =
      is_i_frame ? encodeIFrame(frame) : encodeContent(frame, *matched);
  writeFrame(frame, sizes, bytes, statistics);
  keepForChanges(frame);
  // A cloud without an order may be an exception.
  if (is_i_frame)
    wants_i_frame_ = had_image && !frame.keys.empty() && !frame.image.hasPixels() &&
                     takesImages(true);
  else if (content_.has_image && !frame.keys.empty())
    followImage(frame);
}

/** \brief Encodes payload and supplement of an I-frame. Where the sensor's order of the
 * points is known they are coded with it and without it. With it, if that takes fewer
 * bytes; after a trial some I-frames are not tried, unless they take more bytes than
 * before. */
PayloadSizes
Version1Encoder::encodeIFrame(const VoxelFrame& frame)
{
  const auto encode = [&](bool has_image) {
    const PayloadSizes sizes = encodeWithContent(frame, has_image);
    i_frame_density_ =
        static_cast<double>(payload_.size()) /
        static_cast<double>(std::max<std::uint64_t>(1, header_.point_count));
    return sizes;
  };
  endTrial();
  is_i_frame_empty_ = frame.keys.empty();
  const bool has_image = frame.image.hasPixels() && !is_i_frame_empty_;
  if (settled_i_frames_ > 0 || !has_image) {
    settled_i_frames_ -= settled_i_frames_ > 0 ? 1 : 0;
    const PayloadSizes sizes = encode(has_image && is_image_smaller_);
    if (settled_density_ == 0.0)
      settled_density_ = i_frame_density_;
    else if (i_frame_density_ > near * settled_density_)
      settled_i_frames_ = 0;
    return sizes;
  }
  encode(false);
  const std::size_t size_without = payload_.size();
  const PayloadSizes sizes = encode(true);
  std::vector<std::uint8_t> table;
  ByteWriter writer(table);
  writeImageTable(frame.image, writer);
  const std::size_t size = payload_.size() + table.size();
  settleImages(size, size_without);
  if (is_image_smaller_ && has_p_frames_)
    trial_ = std::make_unique<ImageTrial>(effort_, frame);
  const PayloadSizes chosen = is_image_smaller_ ? sizes : encode(false);
  settled_density_ = i_frame_density_;
  return chosen;
}

/** \brief Encodes payload and supplement of an I-frame. The first large one is also
 * encoded without a refinement: where walls and floors are flat that takes fewer bytes,
 * and more time. */
PayloadSizes
Version1Encoder::encodeWithContent(const VoxelFrame& frame, bool has_image)
{
  constexpr std::size_t large_frame = std::size_t{1} << 18;
  constexpr double smallest_edge = 0.002; // of smaller ones most bits are noise
  const auto encode = [&] {
    setContent(frame, has_image);
    return encodeContent(frame, codedVoxels(frame));
  };
  const PayloadSizes sizes = encode();
  if (content_.refinement_levels == 0 || is_refinement_tried_ ||
      frame.size() < large_frame || frame.grid.resolution < smallest_edge)
    return sizes;
  is_refinement_tried_ = true;
  const std::size_t size = payload_.size();
  is_refinement_useful_ = false;
  const PayloadSizes sizes_without = encode();
  if (payload_.size() <= size)
    return sizes_without;
  is_refinement_useful_ = true;
  return encode();
}

/** \brief Judges an I-frame with an image.
 * \param[in] size_without bytes without
 */
void
Version1Encoder::settleImages(std::size_t size, std::size_t size_without)
{
  is_image_smaller_ = size <= size_without;
  if (std::max(size, size_without) > 2 * std::min(size, size_without))
    settled_i_frames_ = settled_i_frames;
}

/** \brief Judges a P-frame with an image. */
void
Version1Encoder::followImage(const VoxelFrame& frame)
{
  const double density =
      static_cast<double>(payload_.size()) / static_cast<double>(header_.point_count);
  wants_i_frame_ = density > near * i_frame_density_;
  if (wants_i_frame_)
    trial_.reset(); // it would not judge rays that fit
  if (trial_ && trial_->add(frame, payload_.size())) {
    endTrial();
    wants_i_frame_ = !is_image_smaller_;
  }
}

void
Version1Encoder::endTrial()
{
  if (!trial_ || !trial_->hasPFrames())
    return;
  is_image_smaller_ = trial_->isImageBetter();
  settled_i_frames_ = settled_i_frames;
  if (!is_image_smaller_)
    settled_density_ = 0.0; // that of the next I-frame
  trial_.reset();
}

/** \brief Encodes payload and supplement of a frame.
 * \param[in] coded result of codedVoxels
 */
PayloadSizes
Version1Encoder::encodeContent(const VoxelFrame& frame, const VoxelFrame& coded)
{
  header_.coarse_voxel_count = coded.size();
  PayloadSizes sizes = encodePayload(coded);
  const std::size_t supplement_begin = payload_.size();
  encodeSupplement(frame, coded, sizes);
  header_.supplement_size = payload_.size() - supplement_begin;
  return sizes;
}

/** \brief Gives an I-frame as many bytes as decoders of default limits demand for what it
 * has, or finds that a P-frame has too few. */
void
Version1Encoder::pad(const VoxelFrame& frame)
{
  Version1Header& header = header_;
  header.padding_size = 0;
  if (header.is_i_frame)
    bytes_since_i_frame_ = 0;
  bytes_since_i_frame_ += payload_.size();
  const VoxelFrame& coded = content_.hasVoxels() ? coarse_voxels_ : frame;
  const std::uint64_t fewest =
      fewestBytes({header.voxel_count,
                   coded.size() > free_blocks ? countBlocks(coded.keys) : 0,
                   content_.has_point_counts ? header.point_count : 0,
                   fieldValuesOf(header, fields_)});
  lacks_bytes_ = bytes_since_i_frame_ < fewest;
  if (!header.is_i_frame || !lacks_bytes_)
    return;
  header.padding_size = fewest - bytes_since_i_frame_;
  payload_.resize(static_cast<std::size_t>(fewest));
  bytes_since_i_frame_ = fewest;
  lacks_bytes_ = false;
}

/** \brief Appends the frame whose payload is encoded. */
void
Version1Encoder::writeFrame(const VoxelFrame& frame,
                            const PayloadSizes& sizes,
                            std::vector<std::uint8_t>& bytes,
                            CodedFrameStatistics& statistics)
{
  Version1Header& header = header_;
  header.content = content_;
  header.voxel_count = frame.size();
  pad(frame);
  header.payload_size = payload_.size();
  checksum_ =
      writeVersion1Frame(header, payload_, header.is_i_frame ? 0 : checksum_, bytes);

  frame_number_ = header.frame_number;
  statistics.is_i_frame = header.is_i_frame;
  statistics.is_of_changes = header.is_of_changes;
  statistics.has_image = content_.has_image;
  statistics.frame_number = frame_number_;
  statistics.bytes = bytes.size();
  statistics.header_bytes = bytes.size() - payload_.size();
  statistics.occupancy_bytes =
      sizes.occupancy + static_cast<std::size_t>(header.padding_size);
  statistics.attribute_bytes = sizes.attributes;
  statistics.intensity_bytes =
      payload_.size() - statistics.occupancy_bytes - sizes.attributes;
  grid_ = frame.grid;
  intensity_scale_ = frame.intensity_scale;
  has_depth_model_ = frame.depth_model.has_value();
}

/** \brief Keeps a frame, not one of changes, if one of changes may follow. */
void
Version1Encoder::keepForChanges(const VoxelFrame& frame)
{
  if (!has_p_frames_ || content_.hasSupplement() || content_.has_point_counts ||
      !changes::ChangeCoder::mayFollow(
          header_.is_i_frame, frame.size(), payload_.size())) {
    if (changes_)
      changes_->dropLastFrame();
    return;
  }
  if (!changes_)
    changes_ = std::make_unique<changes::ChangeCoder>();
  changes_->prepare(frame);
  changes_->learnWhole(header_.is_i_frame);
}

/** \brief Sets what is in the supplements until the next I-frame. */
void
Version1Encoder::setContent(const VoxelFrame& frame, bool has_image)
{
  content_.colour_bits = frame.colour_bits;
  content_.has_point_counts = frame.has_point_counts;
  content_.has_fields = !frame.fields.empty();
  fields_.assign(frame.fields.begin(), frame.fields.end());
  viewpoint_ = frame.viewpoint;
  header_.fields = fields_;
  header_.viewpoint = viewpoint_;
  content_.has_image = has_image;
  if (has_image) {
    image_.width = frame.image.width;
    image_.height = frame.image.height;
    image_.is_organised = frame.image.is_organised;
    image_.has_points_at_sensor = frame.image.has_points_at_sensor;
    image_.rays = frame.image.rays;
    header_.image = image_;
  }
  content_.refinement_levels =
      is_refinement_useful_ && !has_image ? supplement::chooseRefinement(frame) : 0;
}

/** \brief Appends the supplement to the payload, if the content has one. */
void
Version1Encoder::encodeSupplement(const VoxelFrame& frame,
                                  const VoxelFrame& coarse_voxels,
                                  PayloadSizes& sizes)
{
  header_.point_count = std::accumulate(
      frame.point_counts.begin(), frame.point_counts.end(), std::uint64_t{0});
  if (content_.refinement_levels > 0 && has_p_frames_)
    last_keys_.assign(frame.keys.begin(), frame.keys.end());
  if (!content_.hasSupplement() || frame.keys.empty()) {
    if (supplement_ && header_.is_i_frame)
      supplement_->reset();
    return;
  }
  if (!supplement_)
    supplement_ = std::make_unique<supplement::SupplementCoder>();
  const supplement::Sizes added = supplement_->encode({content_,
                                                       coarse_voxels.keys,
                                                       effort_,
                                                       header_.is_i_frame,
                                                       frame.size(),
                                                       header_.point_count,
                                                       viewpoint_},
                                                      frame,
                                                      payload_);
  sizes.occupancy += added.voxels;
  sizes.attributes += added.attributes;
}

/** \brief Encodes the payload. An I-frame with a depth model is encoded with and
 * without it, as the model does not help if most symbols are saturated. The smaller
 * variant is used until the next I-frame. */
PayloadSizes
Version1Encoder::encodePayload(const VoxelFrame& frame)
{
  if (!frame.depth_model)
    return encodePayloadAs(frame);
  if (header_.is_i_frame || !uses_depth_model_) {
    frame_without_model_.grid = frame.grid;
    frame_without_model_.intensity_scale = frame.intensity_scale;
    frame_without_model_.keys = frame.keys;
    frame_without_model_.intensities = frame.intensities;
    frame_without_model_.has_point_counts = frame.has_point_counts;
    frame_without_model_.point_counts = frame.point_counts;
  }
  if (!header_.is_i_frame)
    return encodePayloadAs(uses_depth_model_ ? frame : frame_without_model_);
  encodePayloadAs(frame_without_model_);
  const std::size_t size_without = payload_.size();
  const PayloadSizes sizes = encodePayloadAs(frame);
  uses_depth_model_ = frame.keys.empty() || payload_.size() <= size_without;
  return uses_depth_model_ ? sizes : encodePayloadAs(frame_without_model_);
}

PayloadSizes
Version1Encoder::encodePayloadAs(const VoxelFrame& frame)
{
  if (header_.is_i_frame)
    depth_model_.reset();
  payload_.clear();
  header_.has_depth_model = frame.depth_model != depth_model_;
  if (header_.has_depth_model)
    writeDepthModel(*frame.depth_model, payload_);
  depth_model_ = frame.depth_model;
  return coder().encode(work_, frame, header_.is_i_frame, payload_);
}

std::size_t
Version1Encoder::endFrame(const VoxelFrame& frame)
{
  const std::size_t needed = frame.size() + frame.fieldValueCount() +
                             frame.image.pixelCount() + payload_.size() +
                             coders_.trackedVoxels(effort_);
  work_.endFrame(needed, needed);
  return needed;
}

void
Version1Encoder::releaseMemory()
{
  payload_ = std::vector<std::uint8_t>();
  coarse_voxels_ = VoxelFrame();
  last_keys_ = std::vector<std::uint64_t>();
  if (supplement_)
    supplement_->releaseMemory();
  if (changes_)
    changes_->releaseMemory();
  frame_without_model_ = VoxelFrame();
  // Without memory for smaller copies the memory stays as it is.
  callOrElse([this] { coder().releaseMemory(); }, [] {});
}

void
Version1Encoder::forgetHistory()
{
  coders_.clear();
  changes_.reset();
  supplement_.reset();
  trial_.reset();
}

} // namespace io
} // namespace pcl_ext
