#include "labelled_voxels.h"

#include <pcl_ext/compression/voxel_frame.h>

#include <cstddef>

namespace pcl_ext {
namespace report {

namespace {

/** \brief Places of a frame's voxels. */
std::vector<LabelledVoxel>
voxelsAtCentres(const io::VoxelFrame& frame)
{
  std::vector<LabelledVoxel> voxels;
  voxels.reserve(frame.size());
  io::forEachVoxelCentre(frame, [&](float x, float y, float z, float) {
    LabelledVoxel voxel;
    voxel.x = x;
    voxel.y = y;
    voxel.z = z;
    voxels.push_back(voxel);
  });
  return voxels;
}

/** \brief Puts a frame's intensities into the voxels that were made of its keys, if it has
 * any. */
void
setIntensities(const io::VoxelFrame& frame,
               float LabelledVoxel::*intensity,
               std::vector<LabelledVoxel>& voxels)
{
  for (std::size_t i = 0; i < frame.size(); ++i)
    voxels[i].*intensity = frame.intensity_scale.value(frame.intensities[i]);
}

} // namespace

std::vector<LabelledVoxel>
labelledVoxels(const noise::LabelledFrame& frame)
{
  using noise::Law;
  std::vector<LabelledVoxel> voxels = voxelsAtCentres(frame.of(Law::Count));
  setIntensities(frame.of(Law::Count), &LabelledVoxel::count, voxels);
  setIntensities(frame.of(Law::Quadratic), &LabelledVoxel::quadratic, voxels);
  setIntensities(frame.of(Law::Linear), &LabelledVoxel::linear, voxels);
  setIntensities(frame.of(Law::Native), &LabelledVoxel::native, voxels);
  for (std::size_t i = 0; i < voxels.size(); ++i)
    voxels[i].is_noise = frame.truth[i] == noise::VoxelTruth::Noise;
  return voxels;
}

} // namespace report
} // namespace pcl_ext
