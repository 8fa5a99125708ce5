#pragma once

#include <pcl_ext/compression/depth_model.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext {

/** \brief Tells from the intensities of a stream how densely its voxels are covered: 1 to
 * 255, which is a voxel face where the unit is Faces, and else so many points.
 *
 * With a depth model a face counts as covered where there are
 * VoxelOutlierRemoval::sure_points_per_square_metre, if there can be as many. */
class VoxelDensities {
public:
  VoxelDensities(DensityUnit unit, float full_intensity)
  : unit_(unit), full_intensity_(full_intensity)
  {}

  /** \brief Follows the stream to its next frame.
   * \param[in] frame a frame; without a depth model it has that of the last that had one
   * \param[in] first position of its grid's first voxel, below 2^23 on each axis, where
   * the voxels of the frames before are where they were; or reset() comes first
   * \return false if densities are in another unit from here on
   */
  bool
  follow(const io::VoxelFrame& frame, const io::VoxelPosition& first);

  /** \brief Begins with a new stream. */
  void
  reset()
  {
    depth_model_.reset();
    numbers_.clear();
  }

  bool
  areFaces() const
  {
    return unit_ == DensityUnit::Faces || depth_model_.has_value();
  }

  /** \brief Density of a voxel of the frame.
   * \param[in] symbol its intensity
   * \param[in] position that of its grid's first voxel and its own in the grid
   */
  std::int16_t
  operator()(std::uint16_t symbol, const io::VoxelPosition& position) const;

private:
  static constexpr unsigned int depth_bits = 10; // of relative depths in factors_

  void
  takeDepthModel(const io::VoxelFrame& frame, const io::VoxelPosition& first);

  void
  makeFactors(unsigned int exponent, double resolution);

  DensityUnit unit_;
  float full_intensity_;
  std::optional<io::DepthModel> depth_model_; // the last one; its origin is position 0
  double model_face_ = 0.0;                   // intensity of a face, as it says
  io::IntensityScale scale_;
  double face_ = 0.0;                  // intensity that is 255
  std::vector<std::uint16_t> numbers_; // by symbol, density in 2^-8 but for the depth
  std::vector<std::uint64_t> factors_; // by relative depth, on numbers_, in 2^-16
  unsigned int exponent_ = 0;          // what factors_ are made for
  double resolution_ = 0.0;
};

} // namespace pcl_ext
