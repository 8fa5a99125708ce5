#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/compression/voxelizer.h>
#include <pcl_ext/nodes/stream_health.h>

#include "nodes/received_stream.h"
#include "voxels/memory_rule.h"

#include <optional>
#include <vector>

namespace pcl_ext {
namespace nodes {

/** \brief Merges the voxels of streams on a common grid, see CentralNode::merge. For one
 * thread at a time. */
class MergedVoxels {
public:
  /** \param[in] resolution voxel edge of the common grid, metres */
  explicit MergedVoxels(double resolution) : resolution_(resolution) {}

  /** \brief Begins a merged frame. */
  void
  clear();

  /** \brief Adds the latest voxels of a stream, if they were decoded between two times. */
  void
  add(const ReceivedStream& stream, Time oldest, Time newest);

  /** \brief Ends the merged frame; empty if it throws. */
  void
  finish(io::VoxelFrame& merged);

private:
  void
  releaseMemory();

  void
  appendCentres(const io::VoxelFrame& frame);

  void
  voxelize(io::VoxelFrame& merged);

  double resolution_;
  std::optional<io::Voxelizer> voxelizer_; // created on first use

  io::MemoryRule memory_rule_;
  // Members so that their memory is reused.
  io::VoxelFrame frame_; // of the last stream that was added
  std::vector<float> coordinates_;
  std::vector<float> intensities_;
};

} // namespace nodes
} // namespace pcl_ext
