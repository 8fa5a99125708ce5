// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/scan_choice.h"

#include "codec/scan/scan_points.h"
#include "codec/scan/scan_stripes.h"
#include "voxels/point_voxels.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief I-frames after a trial that are not tried, if its result was clear. */
constexpr unsigned int most_untried = 15;
/** \brief It is, if the one takes so many times the bytes of the other. */
constexpr double clear_ratio = 2.0;
/** \brief Of what is tried with a part of the points: so many times fewer are fewer of the
 * whole. */
constexpr double surely_fewer = 0.9;
/** \brief A frame with more than so many times the bytes of a point shows another scene,
 * or rays that no longer fit. */
constexpr double most_growth = 1.25;
/** \brief P-frames of a trial. Until then the history of voxels has most of what it
 * needs. */
constexpr unsigned int trial_frames = 8;

/** \brief Bytes that the order of points is worth. Even a scene that stands still takes
 * some for each scan. */
std::size_t
bytesOfOrder(std::size_t points)
{
  constexpr std::size_t points_of_byte = 64;
  constexpr std::size_t most = 256;
  return std::min(points / points_of_byte, most);
}

/** \brief Whether scans take hardly more bytes. */
bool
isScanBetter(double as_scan, double as_voxels)
{
  return 20.0 * as_scan <= 21.0 * as_voxels;
}

} // namespace

bool
ScanChoice::prefersVoxels(const scan::ScanFrame& scan)
{
  is_sampled_ = false;
  // Of a sequence columns are no neighbours.
  if (settings_.keep_order || untried_i_frames_ > 0 || scan.isSequence())
    return false;
  scan::ScanFrame part = scan::stripesOf(scan);
  const std::size_t points = part.pixels.size();
  const auto bytes_of = [this](const auto& frame, const auto&... threads) {
    const CompressionStatus status =
        Trial(settings_).encoder.encode(frame, std::nullopt, bytes_, threads...);
    return status.ok() ? static_cast<double>(bytes_.size()) : 0.0;
  };
  // Fewer points tell little, and then a trial takes little time.
  constexpr std::size_t least_points = 4096;
  if (points < least_points)
    return false;
  const double part_as_scan = bytes_of(part, settings_.threads);
  VoxelFrame voxels;
  scan::movePoints(part, voxels);
  setVoxels(voxels);
  const double part_as_voxels = bytes_of(voxels);
  part.clearPoints(); // all rays, those of the whole scan, stay
  const double rays = bytes_of(part, settings_.threads);
  if (part_as_scan == 0.0 || part_as_voxels == 0.0 || rays == 0.0)
    return false;
  // A part takes more bytes a point than the whole, above all as voxels.
  const double parts =
      static_cast<double>(scan.pixels.size()) / static_cast<double>(points);
  const double as_scan = rays + parts * (part_as_scan - rays);
  const double as_voxels = parts * part_as_voxels;
  if (as_voxels > clear_ratio * as_scan) {
    take(true, most_untried);
    return false;
  }
  if (as_voxels > surely_fewer * as_scan)
    return false;
  take(false, clear_ratio * as_voxels < as_scan ? most_untried : 0);
  return true;
}

/** \brief Takes scans or voxels until the next trial.
 * \param[in] untried_i_frames before it
 */
void
ScanChoice::take(bool scan, unsigned int untried_i_frames)
{
  is_scan_ = scan;
  is_sampled_ = true;
  untried_i_frames_ = untried_i_frames;
  tried_density_ = 0.0; // that of the frame
  trial_.reset();
}

bool
ScanChoice::wantsVoxels(std::size_t bytes, bool is_i_frame)
{
  if (settings_.keep_order)
    return false;
  if (is_i_frame)
    return !is_sampled_ && untried_i_frames_ == 0;
  if (trial_ == nullptr || mayTakeVoxels(bytes))
    return trial_ != nullptr;
  addPFrame(bytes, bytes);
  return false;
}

bool
ScanChoice::takesVoxels(const VoxelFrame& voxels, std::size_t bytes, bool is_i_frame)
{
  if (voxels.size() == 0) {
    // Without points nothing is told of those to come.
    if (is_i_frame)
      trial_.reset();
    return false;
  }
  if (is_i_frame)
    trial_ = std::make_unique<Trial>(settings_);
  // What cannot be coded takes no bytes; nor does it later, for the stream.
  const bool is_coded = trial_->encoder.encode(voxels, std::nullopt, bytes_).ok();
  const std::size_t as_voxels =
      is_coded ? bytes_.size() + bytesOfOrder(voxels.pointCount()) : 2 * bytes;
  if (!is_i_frame) {
    wants_voxels_ = addPFrame(bytes, as_voxels);
    return false;
  }
  const double as_scan = static_cast<double>(bytes);
  const double coded = static_cast<double>(as_voxels);
  is_scan_ = isScanBetter(as_scan, coded);
  tried_density_ = 0.0; // that of the frame
  const bool is_clear =
      std::max(as_scan, coded) > clear_ratio * std::min(as_scan, coded);
  untried_i_frames_ = is_clear ? most_untried : 0;
  trial_->as_scan.i_frame = bytes;
  trial_->as_voxels.i_frame = as_voxels;
  if (!is_scan_ || settings_.i_frame_rate <= 1)
    trial_.reset();
  return !is_scan_;
}

/** \brief Bytes of all frames from one I-frame to the next, by those of the I-frame and
 * of some P-frames. */
double
ScanChoice::periodBytes(std::size_t i_frame,
                        std::size_t p_frames,
                        unsigned int count) const
{
  return static_cast<double>(i_frame) + static_cast<double>(p_frames) *
                                            (settings_.i_frame_rate - 1.0) /
                                            static_cast<double>(count);
}

/** \brief Whether voxels can take fewer bytes if other P-frames are as this one; if not
 * it need not be coded as voxels. Else the trial would take a still scene ten times the
 * time of its frames. */
bool
ScanChoice::mayTakeVoxels(std::size_t as_scan) const
{
  return !isScanBetter(periodBytes(trial_->as_scan.i_frame, as_scan, 1),
                       periodBytes(trial_->as_voxels.i_frame, 0, 1));
}

/** \brief Adds a P-frame to the trial.
 * \return true if that is over, and voxels take fewer bytes
 */
bool
ScanChoice::addPFrame(std::size_t as_scan, std::size_t as_voxels)
{
  Trial& trial = *trial_;
  if (++trial.p_frames > trial_frames / 2) {
    trial.as_scan.p_frames += as_scan;
    trial.as_voxels.p_frames += as_voxels;
  }
  if (trial.p_frames < trial_frames)
    return false;
  const auto of_period = [this](const TriedBytes& tried) {
    return periodBytes(tried.i_frame, tried.p_frames, trial_frames / 2);
  };
  is_scan_ = isScanBetter(of_period(trial.as_scan), of_period(trial.as_voxels));
  untried_i_frames_ = most_untried;
  tried_density_ = 0.0;
  trial_.reset();
  return !is_scan_;
}

bool
ScanChoice::triesAgain(std::size_t points)
{
  constexpr std::size_t least_points = 1024;
  if (points < least_points || points / 4 <= tried_points_)
    return false;
  untried_i_frames_ = 0;
  return true;
}

bool
ScanChoice::follow(const CodedFrameStatistics& coded, std::size_t points)
{
  const bool wants_voxels = std::exchange(wants_voxels_, false);
  if (is_tried_)
    tried_points_ = points;
  if (points == 0)
    return wants_voxels;
  const double density = static_cast<double>(coded.bytes) / static_cast<double>(points);
  if (!coded.is_i_frame)
    return wants_voxels ||
           (coded.has_points && density > most_growth * i_frame_density_);
  i_frame_density_ = density;
  if (tried_density_ == 0.0)
    tried_density_ = density;
  else if (untried_i_frames_ > 0)
    untried_i_frames_ =
        density > most_growth * tried_density_ ? 0 : untried_i_frames_ - 1;
  return wants_voxels;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
