#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "simulator/labelled_stream.h"

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace tools {

/** \brief What the temporal filter does to a stream; sums over its frames. */
struct FilteredReport {
  unsigned int frames_of_filter = 0; ///< its strength
  std::size_t voxels = 0;            ///< shown ones
  std::size_t bytes = 0;
  double encode_ms = 0.0; ///< from the cloud on
  double decode_ms = 0.0;
  // Voxels of the unfiltered frames, where the truth is known.
  std::size_t surfaces = 0;
  std::size_t surfaces_shown = 0; ///< with a shown voxel at most one voxel away
  std::size_t noise = 0;
  std::size_t noise_hidden = 0;
};

/** \brief A stream that is encoded with the temporal filter and decoded again, to
 * compare it with the unfiltered one. */
class FilteredStream {
public:
  /** \param[in] settings of the unfiltered stream
   * \param[in] pose of the sensor
   */
  FilteredStream(nodes::SensorNodeSettings settings, const WorldPose& pose);

  /** \brief Takes the stream's next cloud.
   * \param[in] unfiltered its voxels
   * \param[in] truth of these voxels; null: unknown
   * \throws std::runtime_error if it cannot be encoded or decoded
   */
  void
  run(const pcl::PCLPointCloud2& cloud,
      const io::VoxelFrame& unfiltered,
      const std::vector<noise::VoxelTruth>* truth);

  const FilteredReport&
  report() const
  {
    return report_;
  }

private:
  void
  compare(const io::VoxelFrame& unfiltered,
          const std::vector<noise::VoxelTruth>& truth);

  nodes::SensorNode node_;
  WorldPose pose_;
  io::FrameDecoder decoder_;
  FilteredReport report_;
  // Of the last frame.
  std::vector<std::uint8_t> bytes_;
  io::VoxelFrame shown_;
};

} // namespace tools
} // namespace pcl_ext
