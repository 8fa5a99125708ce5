/** \file
 * \brief What the report's pictures of TemporalVoxelFilter show.
 */
#pragma once

#include "filtered_stream.h"

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief Writes the bytes of a stream's frames with each filter, temporal_bytes.csv,
 * and the frame in which TemporalVoxelFilter shows the smallest share of the surfaces,
 * temporal_frame.csv. */
class TemporalSamples {
public:
  /** \brief Begins the files.
   * \param[in] folder that is there
   * \param[in] first_judged frame from which on the worst one is looked for
   * \throws std::runtime_error if they cannot be written
   */
  TemporalSamples(const std::string& folder, std::int64_t first_judged);

  /** \brief Adds a frame.
   * \param[in] truth to which it was added last
   * \param[in] frame in any law
   * \param[in] filtered to which it was added, too; one is named "temporal"
   */
  void
  add(const SurfaceHistory& truth,
      const LabelledFrame& frame,
      const std::vector<FilteredStream>& filtered);

  /** \brief Ends the files.
   * \throws std::runtime_error if not all could be written
   */
  void
  close();

private:
  /** \brief A voxel that is measured, shown or both. */
  struct Voxel {
    Eigen::Vector3d centre;
    bool is_measured;
    bool is_shown;
    bool is_noise;  ///< measured, and not of a surface
    bool is_missed; ///< of a surface, and not within one voxel of a shown one
    bool is_ghost;
  };

  void
  keep(const SurfaceHistory& truth,
       const LabelledFrame& frame,
       const FilteredStream& filtered);

  std::string frame_file_;
  std::int64_t first_judged_;
  std::ofstream bytes_;
  double worst_percent_ = 101.0;
  std::int64_t worst_frame_ = 0;
  std::vector<Voxel> worst_;
};

} // namespace noise
} // namespace pcl_ext
