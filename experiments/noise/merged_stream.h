/** \file
 * \brief The voxels of all six sensors on the common grid.
 */
#pragma once

#include "simulator/labelled_stream.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief What CentralNode::merge() makes of several cameras: sums of intensities. A
 * voxel is noise where it is noise for every sensor that sees it; what never moves
 * decides before the person, and the person before the machines.
 * \param[in] frames at least one; all on one grid, with one step of intensity
 * \param[out] merged without depth models; depths are 0
 */
void
mergeFrames(const std::vector<LabelledFrame>& frames, LabelledFrame& merged);

/** \brief The six cameras of the robot cell, merged. */
class MergedStream {
public:
  MergedStream(std::uint32_t seed, double resolution);

  /** \brief A frame, from 0, as mergeFrames() has it. */
  void
  read(std::uint32_t number, LabelledFrame& merged);

  /** \brief The frames of the sensors that the last one was merged of. */
  const std::vector<LabelledFrame>&
  sensorFrames() const
  {
    return frames_;
  }

private:
  std::vector<std::unique_ptr<LabelledStream>> streams_;
  std::vector<LabelledFrame> frames_;
};

} // namespace noise
} // namespace pcl_ext
