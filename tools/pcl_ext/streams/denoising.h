// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "simulator/labelled_stream.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext::tools {

/** \brief What denoising does to a stream; sums over the frames whose truth is known. */
struct DenoisingReport {
  std::size_t noise = 0;            ///< voxels that are noise
  std::size_t noise_removed = 0;    ///< of these
  std::size_t surfaces = 0;         ///< the other voxels
  std::size_t surfaces_removed = 0; ///< of these
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

/** \brief Finds the noise among the decoded voxels of one stream: by
 * VoxelOutlierRemoval, or by a threshold on the intensity where one is given or the
 * voxels are not of an edge that the filter is made for. */
class Denoising {
public:
  /** \param[in] law of the intensities
   * \param[in] resolution voxel edge, metres
   * \param[in] threshold least intensity that stays
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
  VoxelOutlierRemoval removal_;
  bool uses_filter_;
  float least_; // of the log-odds or of the intensities
  DenoisingReport report_;
  std::vector<float> log_odds_;
  std::vector<int> kept_;
};

} // namespace pcl_ext::tools
