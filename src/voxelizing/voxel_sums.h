// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Colours of up to 257 points: red, green and blue from bit 32, 16 and 0 on. */
using PackedColours = std::uint64_t;

/** \param[in] colour as of pcl::PointXYZRGB */
inline PackedColours
packColour(std::uint32_t colour)
{
  return std::uint64_t{colour & 0xff0000} << 16 | std::uint64_t{colour & 0xff00} << 8 |
         (colour & 0xff);
}

/** \brief Sum of the colours of some points. */
struct ColourSum {
  std::uint64_t r = 0;
  std::uint64_t g = 0;
  std::uint64_t b = 0;

  /** \param[in] colour as of pcl::PointXYZRGB */
  void
  add(std::uint32_t colour)
  {
    r += colour >> 16 & 0xff;
    g += colour >> 8 & 0xff;
    b += colour & 0xff;
  }

  void
  addPacked(PackedColours packed)
  {
    r += packed >> 32;
    g += packed >> 16 & 0xffff;
    b += packed & 0xffff;
  }

  void
  add(const ColourSum& other)
  {
    r += other.r;
    g += other.g;
    b += other.b;
  }
};

/** \brief What is summed of the points of a cloud in each voxel, besides their
 * number. */
struct SummedFields {
  bool intensities = false;
  bool colours = false;
};

/** \brief Sums over the points of each voxel. */
struct VoxelSums {
  std::vector<std::uint32_t> counts; ///< number of points
  std::vector<double> intensities;   ///< empty unless summed
  std::vector<ColourSum> colours;    ///< empty unless summed

  void
  resize(std::size_t voxels, const SummedFields& fields)
  {
    counts.resize(voxels);
    intensities.resize(fields.intensities ? voxels : 0);
    colours.resize(fields.colours ? voxels : 0);
  }

  void
  clear()
  {
    resize(0, SummedFields());
  }
};

} // namespace pcl_ext::PCL_EXT_ABI::io
