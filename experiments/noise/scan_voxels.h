/** \file
 * \brief Voxels of labelled scans with the truth of each voxel.
 */
#pragma once

#include <pcl_ext/compression/cloud_encoder.h>

#include "labelled_scans.h"
#include "simulator/labelled_stream.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief Points or voxels that are judged, with what is known of them. */
struct JudgedParts {
  std::vector<std::size_t> indices; ///< of the points or voxels
  std::vector<VoxelTruth> truth;
  std::vector<float> range; ///< from the sensor, metres
};

/** \brief The points of a scan that are judged: those with a return but ignored ones. */
JudgedParts
judgedPoints(const LabelledScan& scan);

/** \brief A scan as voxels. */
struct VoxelizedScan {
  /** \brief Count and Native. `truth` is as VoxelTruth says; of voxels that are not
   * judged it is Noise. */
  LabelledFrame frame;
  std::vector<std::uint32_t> voxel_of_return; ///< of each return of the scan

  /** \brief The voxels that are judged. A voxel is a surface if it holds at least one
   * surface point, noise if all its points are noise, else it is not judged. */
  JudgedParts judged;
};

/** \brief The highest score of each voxel's points: one surface point makes a surface.
 * \param[in] point_scores of each point of the scan
 */
void
highestScores(const LabelledScan& scan,
              const VoxelizedScan& voxels,
              const std::vector<float>& point_scores,
              std::vector<float>& voxel_scores);

/** \brief Divides the scans of one sensor into voxels, as a decoder has them. */
class ScanVoxelizer {
public:
  /** \param[in] resolution voxel edge, metres */
  explicit ScanVoxelizer(double resolution);

  /** \throws std::runtime_error if the scan cannot be voxelized */
  void
  voxelize(const LabelledScan& scan, VoxelizedScan& voxels);

private:
  io::CloudEncoder native_;
  io::CloudEncoder count_;
};

} // namespace noise
} // namespace pcl_ext
