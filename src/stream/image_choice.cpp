// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/image_choice.h"

#include "bytes/byte_writer.h"
#include "stream/image_table.h"
#include "stream/version1_encoder.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace pcl_ext {
namespace io {

namespace {

/** \brief I-frames after a trial that are not tried. */
constexpr unsigned int untried_i_frames = 15;
/** \brief A frame with more than so many times the bytes of a point shows another scene,
 * or rays that no longer fit. */
constexpr double most_growth = 1.25;
/** \brief P-frames of a trial. Until then the history of voxels has most of what it
 * needs. */
constexpr unsigned int trial_frames = 8;

} // namespace

/** \brief Encodes the first frames of a stream with images without these, too: what an
 * I-frame takes does not tell what P-frames take, as where a scene stands still the
 * history of voxels is worth more than rays. */
class ImageTrial {
public:
  /** \param[in] effort of the stream
   * \param[in] frame the I-frame
   */
  ImageTrial(Effort effort, const VoxelFrame& frame) : encoder_(effort, true)
  {
    encode(frame);
  }

  /** \brief Adds a P-frame.
   * \param[in] bytes_with_image that it takes
   * \return true if the trial is over
   */
  bool
  add(const VoxelFrame& frame, std::size_t bytes_with_image)
  {
    // The first frames have little history.
    if (++frames_ == trial_frames / 2)
      with_image_ = without_ = 0;
    if (!encode(frame)) {
      with_image_ += bytes_with_image;
      without_ += bytes_.size();
    }
    return frames_ == trial_frames;
  }

  bool
  hasPFrames() const
  {
    return without_ > 0;
  }

  /** \brief Whether P-frames take fewer bytes with an image, or hardly more, as rows and
   * columns are worth a few bytes. */
  bool
  isImageBetter() const
  {
    return 20 * with_image_ <= 21 * without_;
  }

private:
  /** \brief Encodes a frame without its image.
   * \return whether it is an I-frame
   */
  bool
  encode(const VoxelFrame& frame)
  {
    without_image_ = frame;
    without_image_.image = PointImage();
    bytes_.clear();
    IFrameReasons reasons;
    reasons.is_requested = frames_ == 0;
    if (!reasons.any())
      encoder_.addReasons(without_image_, std::nullopt, reasons);
    CodedFrameStatistics statistics;
    encoder_.encode(reasons.any() ? FrameKind::Intra : FrameKind::Predicted,
                    without_image_,
                    std::nullopt,
                    bytes_,
                    statistics);
    return reasons.any();
  }

  Version1Encoder encoder_;
  VoxelFrame without_image_;
  std::vector<std::uint8_t> bytes_;
  unsigned int frames_ = 0;
  // Of the last frames:
  std::size_t with_image_ = 0;
  std::size_t without_ = 0;
};

ImageChoice::ImageChoice(bool has_p_frames) : has_p_frames_(has_p_frames) {}

ImageChoice::~ImageChoice() = default;
ImageChoice::ImageChoice(ImageChoice&&) noexcept = default;
ImageChoice&
ImageChoice::operator=(ImageChoice&&) noexcept = default;

PayloadSizes
ImageChoice::encodeIFrame(const VoxelFrame& frame,
                          Effort effort,
                          bool had_image,
                          const EncodeIFrame& encode)
{
  const auto densityOf = [](const Encoded& encoded) {
    return static_cast<double>(encoded.bytes) /
           static_cast<double>(std::max<std::uint64_t>(1, encoded.points));
  };
  endTrial();
  is_i_frame_empty_ = frame.keys.empty();
  const bool has_image = frame.image.hasPixels() && !is_i_frame_empty_;
  Encoded encoded;
  if (untried_i_frames_ > 0 || !has_image) {
    untried_i_frames_ -= untried_i_frames_ > 0 ? 1 : 0;
    encoded = encode(has_image && is_smaller_);
    i_frame_density_ = densityOf(encoded);
    if (tried_density_ == 0.0)
      tried_density_ = i_frame_density_;
    else if (i_frame_density_ > most_growth * tried_density_)
      untried_i_frames_ = 0;
  }
  else {
    encoded = tryImage(frame, encode);
    if (is_smaller_ && has_p_frames_)
      trial_ = std::make_unique<ImageTrial>(effort, frame);
    i_frame_density_ = tried_density_ = densityOf(encoded);
  }
  // A cloud without an order may be an exception.
  wants_i_frame_ = had_image && !frame.keys.empty() && !frame.image.hasPixels() &&
                   mayHaveImage(true, had_image);
  return encoded.sizes;
}

/** \brief Encodes an I-frame with its image and without, and at last as it is smaller. */
ImageChoice::Encoded
ImageChoice::tryImage(const VoxelFrame& frame, const EncodeIFrame& encode)
{
  const std::size_t size_without = encode(false).bytes;
  const Encoded with_image = encode(true);
  std::vector<std::uint8_t> table;
  ByteWriter writer(table);
  writeImageTable(frame.image, writer);
  const std::size_t size = with_image.bytes + table.size();
  is_smaller_ = size <= size_without;
  if (std::max(size, size_without) > 2 * std::min(size, size_without))
    untried_i_frames_ = untried_i_frames;
  return is_smaller_ ? with_image : encode(false);
}

void
ImageChoice::followPFrame(const VoxelFrame& frame,
                          bool has_image,
                          const Encoded& encoded)
{
  wants_i_frame_ = false;
  if (!has_image)
    return;
  const double density =
      static_cast<double>(encoded.bytes) / static_cast<double>(encoded.points);
  wants_i_frame_ = density > most_growth * i_frame_density_;
  if (wants_i_frame_)
    trial_.reset(); // it would not judge rays that fit
  if (trial_ && trial_->add(frame, encoded.bytes)) {
    endTrial();
    wants_i_frame_ = !is_smaller_;
  }
}

void
ImageChoice::endTrial()
{
  if (!trial_ || !trial_->hasPFrames())
    return;
  is_smaller_ = trial_->isImageBetter();
  untried_i_frames_ = untried_i_frames;
  if (!is_smaller_)
    tried_density_ = 0.0; // that of the next I-frame
  trial_.reset();
}

void
ImageChoice::forgetTrial()
{
  trial_.reset();
}

} // namespace io
} // namespace pcl_ext
