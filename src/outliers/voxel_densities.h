#pragma once

#include <pcl_ext/compression/depth_model.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext {

/** \brief Computes the densities of the voxels of a stream from their intensities: 1 to 255,
 * in 255ths of a voxel face with the unit Faces, else in points.
 *
 * With a depth model a face counts as covered from
 * VoxelOutlierRemoval::sure_points_per_square_metre on, if there can be as many points. */
class VoxelDensities {
public:
  VoxelDensities(DensityUnit unit, float full_intensity)
  : unit_(unit), full_intensity_(full_intensity)
  {}

  /** \brief Prepares for the stream's next frame.
   * \param[in] frame a frame; without a depth model that of an earlier frame is used
   * \param[in] first position of its grid's first voxel, below 2^23 on each axis. Positions
   * of earlier frames must still be valid; else call reset() first
   * \return false if the unit of the densities has changed
   */
  bool
  follow(const io::VoxelFrame& frame, const io::VoxelPosition& first);

  /** \brief Prepares for a new stream. */
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
   * \param[in] position its position in the grid plus that of the grid's first voxel
   */
  std::int16_t
  operator()(std::uint16_t symbol, const io::VoxelPosition& position) const;

private:
  static constexpr unsigned int depth_bits = 10; // resolution of factors_

  void
  takeDepthModel(const io::VoxelFrame& frame, const io::VoxelPosition& first);

  void
  makeFactors(unsigned int exponent, double resolution);

  DensityUnit unit_;
  float full_intensity_;
  std::optional<io::DepthModel> depth_model_; // the last one, relative to position 0
  double model_face_ = 0.0; // intensity of a covered face in that model
  io::IntensityScale scale_;
  double face_ = 0.0;                  // intensity of density 255
  std::vector<std::uint16_t> numbers_; // density without factor by symbol, 2^8 is 1
  std::vector<std::uint64_t> factors_; // by relative depth, 2^16 is 1
  unsigned int exponent_ = 0;          // of factors_
  double resolution_ = 0.0;
};

} // namespace pcl_ext
