// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * This library's efforts and the published layout, through the class with PCL's
 * interface.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "coders/frame_buffer.h"
#include "coders/stream_coder.h"
#include "meters/decoded_checks.h"

#include <pcl/common/io.h>
#include <pcl/filters/filter.h>

#include <istream>
#include <stdexcept>

namespace pcl_ext {
namespace measuring {

namespace {

class LibraryCoder : public StreamCoder {
public:
  LibraryCoder(const Workload& workload, const Variant& variant)
  : StreamCoder(coderName(variant), Content::VoxelsWithIntensity)
  , encoder_(compressionSettings(workload, variant))
  , decoder_(compressionSettings(workload, variant))
  , intensity_tolerance_(toleranceOf(workload, variant))
  {}

  void
  encode(const InputFrame& frame) override
  {
    buffer_.restart();
    stream_.clear();
    throwUnlessOk(encoder_.encodePointCloud(frame.points, stream_));
    frame_bytes_ = buffer_.size();
  }

  void
  decode() override
  {
    throwUnlessOk(decoder_.decodePointCloud(stream_, decoded_));
  }

  void
  check(const InputFrame& frame) override
  {
    const io::VoxelGrid& grid = encoder_.voxelFrame().grid;
    const Lattice lattice{grid.origin, grid.resolution};
    pcl::copyPointCloud(*decoded_, *positions_);
    checkVoxels(*frame.positions, *positions_, lattice, /* face_tolerance */ 0.0);
    checkIntensities(
        *frame.points, *decoded_, lattice, /* top */ 255.0, intensity_tolerance_);
  }

private:
  using Compression = io::OctreePointCloudIntensityCompression<pcl::PointXYZI>;

  /** \brief Counts are exact; shares are rounded, in the published layout cut off.
   * 0.001 allows for sums of floats in another order. */
  static double
  toleranceOf(const Workload& workload, const Variant& variant)
  {
    if (workload.law == IntensityLaw::Count)
      return 0.0;
    return variant.format == io::StreamFormat::Published ? 1.001 : 0.501;
  }

  Compression encoder_;
  Compression decoder_;
  double intensity_tolerance_;
  FrameBuffer buffer_;
  std::iostream stream_{&buffer_};
  IntensityCloud::Ptr decoded_{new IntensityCloud};
};

/** \brief All points, of organised clouds with their rows and columns; no intensity. */
class LibraryPointsCoder : public StreamCoder {
public:
  LibraryPointsCoder(const Workload& workload, const Variant& variant)
  : StreamCoder(coderName(variant), Content::Points)
  , encoder_(settingsOf(workload, variant))
  , decoder_(settingsOf(workload, variant))
  {}

  void
  encode(const InputFrame& frame) override
  {
    buffer_.restart();
    stream_.clear();
    throwUnlessOk(encoder_.encodePointCloud(frame.raw, stream_));
    frame_bytes_ = buffer_.size();
  }

  void
  decode() override
  {
    throwUnlessOk(decoder_.decodePointCloud(stream_, decoded_));
  }

  void
  check(const InputFrame& frame) override
  {
    const io::VoxelFrame& voxels = encoder_.voxelFrame();
    const io::VoxelGrid& grid = voxels.grid;
    pcl::Indices kept;
    pcl::removeNaNFromPointCloud(*decoded_, *positions_, kept);
    if (voxels.points.areThere())
      checkPointsInOrder(*frame.positions, *positions_, grid.resolution);
    else
      checkPoints(*frame.positions, *positions_, {grid.origin, grid.resolution});
  }

private:
  using Compression =
      io::OctreePointCloudIntensityCompression<pcl::PointXYZ, NoIntensity>;

  static io::IntensityCompressionSettings
  settingsOf(const Workload& workload, const Variant& variant)
  {
    io::IntensityCompressionSettings settings;
    settings.resolution = workload.resolution;
    settings.i_frame_rate = workload.i_frame_rate;
    settings.effort = variant.effort;
    settings.keep_points = true;
    return settings;
  }

  Compression encoder_;
  Compression decoder_;
  FrameBuffer buffer_;
  std::iostream stream_{&buffer_};
  PositionCloud::Ptr decoded_{new PositionCloud};
};

} // namespace

void
addLibraryCoders(const Workload& workload, StreamCoders& coders)
{
  for (const Variant& variant : libraryVariants())
    addLibraryCoder(workload, variant, coders);
}

void
addLibraryCoder(const Workload& workload, const Variant& variant, StreamCoders& coders)
{
  coders.push_back(std::make_unique<LibraryCoder>(workload, variant));
}

void
addLibraryPointsCoders(const Workload& workload, StreamCoders& coders)
{
  for (const Variant& variant : libraryVariants())
    if (variant.format == io::StreamFormat::Version1)
      coders.push_back(std::make_unique<LibraryPointsCoder>(workload, variant));
}

} // namespace measuring
} // namespace pcl_ext
