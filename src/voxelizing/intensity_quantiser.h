// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/intensity/intensity_model.h>

#include "voxelizing/common_step.h"
#include "voxelizing/held_range.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Quantises voxel intensities to symbols, and chooses the scale as far as the
 * settings leave it automatic, by the rule of heldRange. */
class PCL_EXT_CODEC_EXPORT IntensityQuantiser {
public:
  /** \brief A quantiser for one stream.
   * \param[in] settings as accepted by checkSettings
   * \param[in] unit unit of the intensities
   * \param[in] spans_all whether an automatic range has all values, also the few highest
   * and lowest ones that heldRange leaves out
   */
  IntensityQuantiser(const EncoderSettings& settings,
                     IntensityUnit unit,
                     bool spans_all = false);

  /** \brief Quantises the voxels of one frame.
   * \param[in] values voxel intensities, sums or means, in their unit
   * \param[in] step of the intensities of all points
   * \param[in] may_refit ignore the values of previous frames. They are ignored in any
   * case if the scale is so wide for them that few of its numbers are used
   * \param[out] frame its scale and its symbols are set
   * \param[out] vanished number of voxels whose value is less than half a step from 0,
   * but not 0
   * \return number of voxels clamped to an end of the scale
   */
  std::size_t
  quantise(const std::vector<double>& values,
           const CommonStep& step,
           bool may_refit,
           VoxelFrame& frame,
           std::size_t& vanished);

  /** \brief True if quantiseCounts does what quantise does: the scale remains, and the
   * number of a count is the count itself or one less, clamped to the scale.
   * \param[in] counts number of points in each voxel
   * \param[in] may_refit see quantise
   */
  bool
  takesCounts(const std::vector<std::uint32_t>& counts, bool may_refit) const;

  /** \brief Quantises the voxels of one frame, if takesCounts().
   * \param[in] counts number of points in each voxel
   * \param[out] frame as above
   * \return as above
   */
  std::size_t
  quantiseCounts(const std::vector<std::uint32_t>& counts, VoxelFrame& frame) const;

  /** \brief Releases memory of earlier frames. */
  void
  releaseMemory();

private:
  void
  followValues(const std::vector<double>& values,
               const CommonStep& step,
               bool may_refit);

  void
  fitScale(const std::vector<double>& values, const CommonStep& step, bool may_refit);

  bool
  setExactScale(unsigned int divisor, double highest);

  bool
  isTooWide(const ValueRange& held) const;

  void
  spanScale(double offset, double range, unsigned int automatic_bits);

  /** \brief Sets the companded scale of counts, at first, or of shares. */
  void
  compandFirstScale(IntensityUnit unit);

  /** \brief Sets a companded scale, or a linear one if its bits suffice for all
   * numbers.
   * \param[in] offset decoded intensity of number 0
   * \param[in] range from there to that of the highest number
   * \param[in] step from one number to the next
   */
  void
  spanNumbers(double offset, double range, double step);

  unsigned int
  compandedBits() const;

  /** \brief Replaces numbers by their levels, if the scale is companded. */
  void
  compandNumbers(std::vector<std::uint16_t>& numbers) const;

  bool follows_values_;
  bool spans_all_;
  bool truncates_; // the published layout truncates, version 1 rounds
  bool is_companded_;
  bool is_unit_points_;
  bool are_counts_;         // intensities, if integers, begin at 1 as counts do
  double unit_factor_;      // a share of 1 is decoded as 255
  unsigned int fixed_bits_; // 0: automatic
  double fixed_range_;      // 0: automatic
  CommonStep step_;         // of the values that the scale is adapted to
  bool is_exact_ = false;   // the scale has these values as they are
  double lowest_ = 0.0;     // of these
  double highest_ = 0.0;
  ValueRange held_; // of the frame
  IntensityScale scale_;
  std::vector<std::uint16_t> levels_; // by number; companded scales only
  std::vector<double> sorted_values_; // see heldRange; a member to reuse its memory
};

} // namespace pcl_ext::PCL_EXT_ABI::io
