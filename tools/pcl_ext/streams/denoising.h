#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "simulator/labelled_stream.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext {
namespace tools {

/** \brief Voxels that one way of denoising removes. */
struct RemovedVoxels {
  std::size_t all = 0;
  std::size_t noise = 0;    ///< of these, where the truth is known
  std::size_t surfaces = 0; ///< the others of these
};

/** \brief What denoising does to a stream; sums over its frames. */
struct DenoisingReport {
  float threshold = 0.0f;
  bool has_filter = false;         ///< the outlier filter works on this stream
  bool uses_filter = false;        ///< it made the denoised clouds, else the threshold
  std::size_t labelled_voxels = 0; ///< whose truth is known
  std::size_t noise_voxels = 0;    ///< of these noise
  RemovedVoxels by_threshold;
  RemovedVoxels by_filter;
  double ms = 0.0; ///< processor time of the way that made the denoised clouds
};

/** \brief Truth of the voxels of the robot cell. */
class CellTruth {
public:
  /** \param[in] sensor of the cell
   * \param[in] resolution voxel edge, metres
   */
  CellTruth(std::uint32_t seed, unsigned int sensor, double resolution);

  /** \brief What the voxels of a frame are.
   * \return null if the frame has other voxels than the cell's crop box
   */
  const std::vector<noise::VoxelTruth>*
  of(std::size_t number, const io::VoxelFrame& frame);

private:
  noise::LabelledStream stream_;
  noise::LabelledFrame labelled_;
};

/** \brief Finds the noise among the decoded voxels of one stream: by a threshold on the
 * intensity, and by VoxelOutlierRemoval. */
class Denoising {
public:
  /** \param[in] law of the intensities
   * \param[in] resolution voxel edge, metres
   * \param[in] threshold least intensity that denoising keeps; none: the outlier filter
   * denoises
   */
  Denoising(IntensityLaw law, double resolution, const std::optional<float>& threshold);

  /** \brief Judges the stream's next frame.
   * \param[in] frame as decoded
   * \param[in] intensities of the decoded points, one for each voxel
   * \param[in] truth of the voxels; null: unknown
   * \return indices of the voxels that stay
   */
  const std::vector<int>&
  voxelsToKeep(const io::VoxelFrame& frame,
               const std::vector<float>& intensities,
               const std::vector<noise::VoxelTruth>* truth);

  const DenoisingReport&
  report() const
  {
    return report_;
  }

private:
  VoxelOutlierRemovalSettings settings_;
  VoxelOutlierRemoval removal_;
  DenoisingReport report_;
  std::vector<float> log_odds_;
  std::vector<int> kept_;
};

} // namespace tools
} // namespace pcl_ext
