#pragma once

#include <pcl_ext/compression/depth_model.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext {

/** \brief Tells from the intensities of a stream how densely its voxels are covered: 1 to
 * 255, which is a voxel face where the unit is Faces, and else so many points. */
class VoxelDensities {
public:
  VoxelDensities(DensityUnit unit, float full_intensity)
  : unit_(unit), full_intensity_(full_intensity)
  {}

  /** \brief Follows the stream to its next frame.
   * \return false if densities are in another unit from here on
   */
  bool
  follow(const io::VoxelFrame& frame);

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
   * \param[in] position in the grid
   */
  std::int16_t
  operator()(std::uint16_t symbol, const io::VoxelPosition& position) const;

private:
  DensityUnit unit_;
  float full_intensity_;
  std::optional<io::DepthModel> depth_model_; // the last one that came
  io::IntensityScale scale_;
  double face_ = 0.0;                  // intensity that is 255
  std::vector<std::uint16_t> numbers_; // by symbol, density in 2^-8 but for the depth
};

} // namespace pcl_ext
