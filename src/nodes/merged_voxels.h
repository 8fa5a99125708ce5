// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/nodes/stream_health.h>

#include "nodes/received_stream.h"
#include "voxelizing/voxelizer.h"
#include "voxels/memory_rule.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext {
namespace nodes {

/** \brief Merges the voxels of streams on a common grid, see CentralNode::merge. For
 * one thread at a time. */
class MergedVoxels {
public:
  using Origin = std::array<double, 3>;

  /** \param[in] resolution voxel edge of the common grid, metres
   * \param[in] origin of the common grid, metres; none: chosen from the voxels
   */
  MergedVoxels(double resolution, const std::optional<Origin>& origin);

  /** \brief Begins a merged frame. */
  void
  clear();

  /** \brief Adds the latest voxels of a stream, if they were decoded between two times or
   * have one of some stamps.
   * \return the frame that they are from; nothing if there are none */
  std::optional<LatestFrame>
  add(ReceivedStream& stream,
      Time oldest,
      Time newest,
      const std::optional<StampRange>& stamps);

  /** \brief Ends the merged frame. Tells the streams how many of
   * their voxels are outside the common grid, and how many intensities were reduced. */
  void
  finish(io::VoxelFrame& merged);

  /** \brief Drops the merged frame and all memory. To be called when add() or finish()
   * threw, as the voxelizer may contain a part of the points. */
  void
  releaseMemory();

private:
  using Index = std::array<std::int32_t, 3>;

  /** \brief A voxel of a stream. */
  struct Voxel {
    std::array<double, 3> centre; ///< metres
    float intensity;
    bool has_colour;
    io::VoxelColour colour; ///< in channels of 0 to 255
  };

  /** \brief The voxel of the merged frame that contains a coloured one of a stream. */
  struct ColouredVoxel {
    std::uint64_t key;
    io::VoxelColour colour; ///< in channels of 0 to 255
  };

  /** \brief The voxels of a stream: up to `end`, from that of the one before it. */
  struct Part {
    ReceivedStream* stream;
    std::size_t end;
    Origin middle; ///< of the stream's grid, metres
  };

  void
  appendVoxels(const io::VoxelFrame& frame);

  bool
  findIndex(const Voxel& voxel, const Origin& origin, Index& index) const;

  std::size_t
  countOnLattice(const Origin& origin) const;

  /** \brief Moves the origin to where more voxels are on its lattice, if there is such
   * a one. */
  bool
  moveOrigin();

  /** \brief The median of the streams' median magnitudes, of intensities that are not
   * 0; 0 if all are. Of two medians the lower one: a faulty intensity is a large
   * one. */
  double
  typicalIntensity();

  /** \brief The largest magnitude of an intensity beside which those of all streams
   * have steps on a scale of 16 bits, see CentralNode::merge. */
  float
  intensityLimit();

  /** \brief Sets coordinates_ and intensities_ from the voxels that are on the lattice.
   * \param[in] limit of the magnitude of intensities
   */
  void
  locateVoxels(float limit);

  void
  voxelize(io::VoxelFrame& merged);

  void
  mergeColours(io::VoxelFrame& merged);

  double resolution_;
  bool has_fixed_origin_;
  Origin origin_{};
  std::optional<io::Voxelizer> voxelizer_; // created on first use

  io::MemoryRule memory_rule_;
  // Members so that their memory is reused.
  io::VoxelFrame frame_; // of the last stream that was added
  std::vector<Voxel> voxels_;
  std::vector<Part> parts_;
  std::vector<float> coordinates_; // voxels from the origin
  std::vector<float> intensities_;
  std::vector<float> magnitudes_; // of the intensities of one stream
  std::vector<ColouredVoxel> coloured_voxels_;
  std::vector<ColouredVoxel> spare_colours_;
};

} // namespace nodes
} // namespace pcl_ext
