// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Voxel frames of the robot cell with the truth of each voxel.
 */
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/intensity/intensity_law.h>

#include "simulator/cell_voxelizer.h"
#include "simulator/robot_cell.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief What is in a voxel. */
enum class VoxelTruth : std::uint8_t {
  Noise,   ///< points of no surface alone: flying pixels, speckle, snow, dust
  Still,   ///< a point, at least, of a surface that never moves
  Machine, ///< of surfaces, those of the robots and the gantry alone
  Person   ///< a point of the person's, and none of a surface that never moves
};
constexpr std::size_t voxel_truth_count = 4;

/** \brief The paper's laws of intensity, in the order of its sections 2.5.1 to 2.5.3,
 * and the sensor's own intensity. */
using Law = IntensityLaw;
constexpr std::size_t law_count = 4;

/** \brief The laws of a depth camera, which has no intensity of its own. */
constexpr std::array<Law, 3> camera_laws = {Law::Count, Law::Quadratic, Law::Linear};

/** \brief The laws of a lidar, whose beams do not spread as pixels do. */
constexpr std::array<Law, 2> lidar_laws = {Law::Native, Law::Count};

/** \brief One frame of a sensor, in all laws that the sensor has. */
struct LabelledFrame {
  /** \brief As a decoder hands them over: what is in voxels is coded without loss. The
   * keys are the same for all laws; those that the sensor does not have are empty. */
  std::array<io::VoxelFrame, law_count> voxels;
  std::vector<VoxelTruth> truth; ///< of each voxel

  io::VoxelFrame&
  of(Law law)
  {
    return voxels[static_cast<std::size_t>(law)];
  }

  const io::VoxelFrame&
  of(Law law) const
  {
    return voxels[static_cast<std::size_t>(law)];
  }
};

/** \brief Sets the truth of the voxels that hold some of a frame's points.
 * \param[in] some voxels of these points alone, on the frame's grid
 * \param[in] truth what they are
 * \param[in,out] frame its voxels; their truth is set
 * \throws std::logic_error if it has not all of these voxels
 */
void
markTruth(const io::VoxelFrame& some, VoxelTruth truth, LabelledFrame& frame);

/** \brief Centre of a voxel, world, metres. */
Eigen::Vector3d
centreOf(const io::VoxelGrid& grid, std::uint64_t key);

/** \brief The voxels that one sensor's computer makes of the robot cell. */
class LabelledStream {
public:
  /** \brief A stream of one sensor.
   * \param[in] seed of the cell
   * \param[in] sensor 1..6
   * \param[in] resolution voxel edge, metres
   */
  LabelledStream(std::uint32_t seed, unsigned int sensor, double resolution);

  /** \brief A frame, from 0; frames may be asked for in any order. */
  void
  read(std::uint32_t number, LabelledFrame& frame);

private:
  /** \brief Voxels of the surfaces that a mover has, of the captured frame. */
  const io::VoxelFrame&
  surfaceVoxelsOf(cell::Mover mover);

  unsigned int sensor_;
  cell::RobotCell cell_;
  template <typename LawT>
  using Model = IntensityModel<KinectV2, LawT>;

  CellVoxelizer<Model<CountLaw>> count_;
  CellVoxelizer<Model<QuadraticLaw>> quadratic_;
  CellVoxelizer<Model<LinearLaw>> linear_;

  cell::CellFrame captured_;
  std::vector<cell::Mover> movers_;
  pcl::PointCloud<pcl::PointXYZ> surfaces_; // some of the points, the others NaN
  io::VoxelFrame surface_voxels_;
};

} // namespace noise
} // namespace pcl_ext
