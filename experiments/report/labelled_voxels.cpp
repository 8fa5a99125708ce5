#include "labelled_voxels.h"

#include <pcl_ext/compression/symbol_intensities.h>
#include <pcl_ext/compression/voxel_centres.h>

#include <cstddef>

namespace pcl_ext {
namespace report {

namespace {

/** \brief Places of a frame's voxels. */
std::vector<LabelledVoxel>
voxelsAtCentres(const io::VoxelFrame& frame)
{
  io::SymbolIntensities intensities;
  std::vector<LabelledVoxel> voxels(frame.size());
  io::VoxelCentres centres;
  for (std::size_t begin = 0; begin < frame.size();) {
    const std::size_t count = io::voxelCentres(frame, intensities, begin, centres);
    for (std::size_t i = 0; i < count; ++i) {
      voxels[begin + i].x = centres.x[i];
      voxels[begin + i].y = centres.y[i];
      voxels[begin + i].z = centres.z[i];
    }
    begin += count;
  }
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
