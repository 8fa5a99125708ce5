#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/intensity/intensity_model.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Turns voxel intensities into symbols, and chooses the scale where the user
 * left that to the library. */
class IntensityQuantiser {
public:
  /** \brief A quantiser for one stream.
   * \param[in] settings as accepted by checkSettings
   * \param[in] unit unit of the intensities
   */
  IntensityQuantiser(const IntensityCompressionSettings& settings, IntensityUnit unit);

  /** \brief Quantises the voxels of one frame.
   * \param[in] values voxel intensities, sums or means, in their unit
   * \param[in] all_whole_numbers true if every point of the frame had a whole number
   * \param[in] may_refit forget the values of the frames before this one
   * \param[out] frame its scale and its symbols are set
   * \return number of voxels beyond an end of the scale, which hold that end's symbol
   */
  std::size_t
  quantise(const std::vector<double>& values,
           bool all_whole_numbers,
           bool may_refit,
           VoxelFrame& frame);

  /** \brief True if the symbol of a count is the count itself, held within the scale. */
  bool
  takesCounts() const;

  /** \brief Quantises the voxels of one frame, if takesCounts().
   * \param[in] counts number of points in each voxel
   * \param[out] frame as above
   * \return as above
   */
  std::size_t
  quantiseCounts(const std::vector<std::uint32_t>& counts, VoxelFrame& frame) const;

private:
  void
  followValues(const std::vector<double>& values, bool all_whole_numbers);

  void
  spanScale(double offset, double range, unsigned int automatic_bits);

  /** \brief The companded scale of counts or shares, which follow no values. */
  void
  compandFixedScale(IntensityUnit unit);

  /** \brief A companded scale; a linear one if its bits are enough for the numbers.
   * \param[in] offset intensity of number 0, as it is shown
   * \param[in] range from there to the highest number
   * \param[in] step from one number to the next
   */
  void
  spanNumbers(double offset, double range, double step);

  unsigned int
  compandedBits() const;

  /** \brief Puts the level of each number in its place, where the scale has levels. */
  void
  compandNumbers(std::vector<std::uint16_t>& numbers) const;

  bool follows_values_;
  bool truncates_; // the published layout drops the fraction, the paper rounds
  bool is_companded_;
  bool are_counts_;         // intensities, if whole, begin at 1 as counts do
  double unit_factor_;      // a share of 1 shows as 255
  unsigned int fixed_bits_; // 0: automatic
  double fixed_range_;      // 0: automatic
  bool had_fractions_ = false;
  double lowest_ = 0.0; // of the values that the scale follows
  double highest_ = 0.0;
  IntensityScale scale_;
  std::vector<std::uint16_t> levels_; // by number; of a companded scale
};

} // namespace io
} // namespace pcl_ext
