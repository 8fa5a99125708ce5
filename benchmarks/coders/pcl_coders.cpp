// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * PCL's class in its two modes: voxels, and all points.
 */
#include "coders/frame_buffer.h"
#include "coders/pcl_compression.h"
#include "coders/stream_coder.h"
#include "meters/decoded_checks.h"

#include <cmath>
#include <istream>
#include <stdexcept>
#include <string>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief PCL's box grows in steps, so that its corner has the rounding errors of some
 * additions. Voxels. */
constexpr double corner_rounding = 1e-9;

/** \brief PCL divides by the point resolution as a float. Point resolutions. */
constexpr double point_rounding = 1e-5;

class PclCoder : public StreamCoder {
public:
  PclCoder(std::string name, Content content, const PclCompressionSettings& settings)
  : StreamCoder(std::move(name), content), encoder_(settings), decoder_(settings)
  {}

  void
  encode(const InputFrame& frame) override
  {
    buffer_.restart();
    stream_.clear();
    encoder_.encode(frame.positions, stream_);
    frame_bytes_ = buffer_.size();
    if (frame_bytes_ == 0)
      throw std::runtime_error("PCL encoded nothing; its decoder would wait for ever");
  }

  void
  decode() override
  {
    decoder_.decode(stream_, positions_);
  }

protected:
  Lattice
  lattice() const
  {
    return {encoder_.lowerCorner(), encoder_.resolution()};
  }

private:
  PclCompression<pcl::PointXYZ> encoder_;
  PclCompression<pcl::PointXYZ> decoder_;
  FrameBuffer buffer_;
  std::iostream stream_{&buffer_};
};

class PclVoxelGridCoder : public PclCoder {
public:
  explicit PclVoxelGridCoder(const PclCompressionSettings& settings)
  : PclCoder(pcl_voxel_grid_name, Content::Voxels, settings)
  {}

  void
  check(const InputFrame& frame) override
  {
    checkVoxels(*frame.positions, *positions_, lattice(), corner_rounding);
  }
};

class PclPointsCoder : public PclCoder {
public:
  /** \param[in] centred whether half a point resolution is added to what is decoded, so
   * that the error is at most that */
  PclPointsCoder(const std::string& name,
                 const PclCompressionSettings& settings,
                 bool centred)
  : PclCoder(name, Content::Points, settings)
  , edge_(settings.point_resolution)
  , centred_(centred)
  {}

  /** \brief The points are cut off to whole numbers of the point resolution from the
   * corner of a voxel, which is a whole number of them from that of the box: so they are
   * voxels, too. */
  void
  check(const InputFrame& frame) override
  {
    PositionCloud centres = *positions_;
    if (centres.size() != frame.positions->size())
      throw std::runtime_error("PCL decoded " + std::to_string(centres.size()) +
                               " points of " + std::to_string(frame.positions->size()));
    for (pcl::PointXYZ& point : centres)
      point.getVector3fMap().array() += static_cast<float>(0.5 * edge_);
    // Moved by whole numbers: the box of distant points may begin too far away to check.
    Lattice near_origin{lattice().origin, edge_};
    for (double& coordinate : near_origin.origin)
      coordinate = std::fmod(coordinate, edge_);
    checkVoxels(
        *frame.positions, centres, near_origin, point_rounding, Repeats::Allowed);
    if (centred_)
      positions_->swap(centres);
  }

private:
  double edge_;
  bool centred_;
};

} // namespace

void
addPclVoxelGridCoder(const Workload& workload, StreamCoders& coders)
{
  PclCompressionSettings settings;
  settings.octree_resolution = workload.resolution;
  settings.point_resolution = workload.resolution;
  settings.keeps_voxels_only = true;
  settings.i_frame_rate = workload.i_frame_rate;
  coders.push_back(std::make_unique<PclVoxelGridCoder>(settings));
}

void
addPclMillimetreCoder(const Workload& workload, StreamCoders& coders)
{
  // The octree only sorts the points; its edge is the class's default, as a larger one
  // than 12.7 cm would cut off the differences, which are bytes.
  PclCompressionSettings settings;
  settings.octree_resolution = 0.01;
  settings.point_resolution = 0.001;
  settings.keeps_voxels_only = false;
  settings.i_frame_rate = workload.i_frame_rate;
  coders.push_back(std::make_unique<PclPointsCoder>("PCL, 1 mm", settings, false));
}

void
addPclPointsCoder(const Workload& workload, StreamCoders& coders)
{
  PclCompressionSettings settings;
  // The edge with the fewest bytes: twice as large takes up to 13 times as many at 4 cm.
  settings.octree_resolution = workload.resolution;
  settings.point_resolution = workload.resolution;
  settings.keeps_voxels_only = false;
  settings.i_frame_rate = workload.i_frame_rate;
  coders.push_back(std::make_unique<PclPointsCoder>("PCL", settings, true));
}

} // namespace measuring
} // namespace pcl_ext
