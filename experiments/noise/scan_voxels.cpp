#include "scan_voxels.h"

#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/point_intensity.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace noise {

namespace {

io::EncoderSettings
settingsFor(double resolution)
{
  io::EncoderSettings settings;
  settings.resolution = resolution;
  settings.origin = std::array<double, 3>{};
  return settings;
}

VoxelTruth
truthOf(PointClass point)
{
  switch (point) {
  case PointClass::Surface:
    return VoxelTruth::Still;
  case PointClass::Person:
    return VoxelTruth::Person;
  case PointClass::Pole:
    return VoxelTruth::Pole;
  default:
    return VoxelTruth::Noise;
  }
}

/** \brief What of a voxel's points decides: a surface before a person before a pole
 * before what is ignored before noise. */
int
rank(PointClass point)
{
  switch (point) {
  case PointClass::Surface:
    return 4;
  case PointClass::Person:
    return 3;
  case PointClass::Pole:
    return 2;
  case PointClass::Ignored:
    return 1;
  default:
    return 0;
  }
}

/** \brief Index of the voxel of a point; the number of voxels if there is none. */
std::size_t
findVoxel(const io::VoxelFrame& frame, const std::array<std::int64_t, 3>& position)
{
  for (const std::int64_t along : position)
    if (along < 0 || along >= frame.grid.size())
      return frame.keys.size();
  const std::uint64_t key = io::mortonKey({static_cast<std::uint32_t>(position[0]),
                                           static_cast<std::uint32_t>(position[1]),
                                           static_cast<std::uint32_t>(position[2])});
  const auto found = std::lower_bound(frame.keys.begin(), frame.keys.end(), key);
  return found != frame.keys.end() && *found == key
             ? static_cast<std::size_t>(found - frame.keys.begin())
             : frame.keys.size();
}

/** \brief Index of the voxel that a point is in. The voxelizer rounds in its own way, so
 * that a point on a face may be on its other side. */
std::uint32_t
voxelOf(const pcl::PointXYZI& point, const io::VoxelFrame& frame)
{
  const io::VoxelGrid& grid = frame.grid;
  constexpr double rounding = 1e-4; // of an edge
  std::array<std::array<std::int64_t, 2>, 3> sides{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double place =
        (static_cast<double>(point.data[axis]) - grid.origin[axis]) / grid.resolution -
        grid.first_index[axis];
    const double exact = std::floor(place);
    const double other = place - exact < 0.5 ? std::floor(place - rounding)
                                             : std::floor(place + rounding);
    sides[axis] = {static_cast<std::int64_t>(exact), static_cast<std::int64_t>(other)};
  }
  for (std::size_t choice = 0; choice < 8; ++choice) {
    const std::size_t voxel = findVoxel(
        frame,
        {sides[0][choice & 1], sides[1][choice >> 1 & 1], sides[2][choice >> 2]});
    if (voxel < frame.keys.size())
      return static_cast<std::uint32_t>(voxel);
  }
  throw std::logic_error("a point is in none of its scan's voxels");
}

/** \brief Truth and ranges of the voxels by their points. */
void
judgeVoxels(const LabelledScan& scan, VoxelizedScan& voxels)
{
  LabelledFrame& frame = voxels.frame;
  const io::VoxelFrame& counts = frame.of(Law::Count);
  std::vector<PointClass> classes(counts.size(), PointClass::Noise);
  for (std::size_t i = 0; i < voxels.voxel_of_return.size(); ++i) {
    PointClass& of_voxel = classes[voxels.voxel_of_return[i]];
    const PointClass of_point = scan.classes[scan.index_of_return[i]];
    if (rank(of_point) > rank(of_voxel))
      of_voxel = of_point;
  }
  frame.truth.clear();
  frame.depth.clear();
  voxels.judged = JudgedParts();
  for (std::size_t i = 0; i < classes.size(); ++i) {
    frame.truth.push_back(truthOf(classes[i]));
    frame.depth.push_back(
        static_cast<float>(centreOf(counts.grid, counts.keys[i]).norm()));
    if (classes[i] == PointClass::Ignored)
      continue;
    voxels.judged.indices.push_back(i);
    voxels.judged.truth.push_back(frame.truth.back());
    voxels.judged.range.push_back(frame.depth.back());
  }
}

} // namespace

JudgedParts
judgedPoints(const LabelledScan& scan)
{
  JudgedParts judged;
  for (const std::size_t i : scan.index_of_return)
    if (scan.classes[i] != PointClass::Ignored) {
      judged.indices.push_back(i);
      judged.truth.push_back(truthOf(scan.classes[i]));
      judged.range.push_back(scan.cloud[i].getVector3fMap().norm());
    }
  return judged;
}

void
highestScores(const LabelledScan& scan,
              const VoxelizedScan& voxels,
              const std::vector<float>& point_scores,
              std::vector<float>& voxel_scores)
{
  voxel_scores.assign(voxels.frame.truth.size(),
                      -std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < voxels.voxel_of_return.size(); ++i) {
    float& score = voxel_scores[voxels.voxel_of_return[i]];
    score = std::max(score, point_scores[scan.index_of_return[i]]);
  }
}

ScanVoxelizer::ScanVoxelizer(double resolution)
: native_(settingsFor(resolution),
          NativeIntensity::unit,
          io::depthLawOf(NativeIntensity(resolution)))
, count_(settingsFor(resolution),
         CountIntensity::unit,
         io::depthLawOf(CountIntensity(resolution)))
{}

void
ScanVoxelizer::voxelize(const LabelledScan& scan, VoxelizedScan& voxels)
{
  const WorldPose pose(Eigen::Isometry3d::Identity());
  Centres counted = *scan.returns;
  for (pcl::PointXYZI& point : counted)
    point.intensity = 1.0f;
  for (const auto& [points, encoder, law] :
       {std::tuple(scan.returns.get(), &native_, Law::Native),
        std::tuple(&counted, &count_, Law::Count)})
    if (const auto status = encoder->voxelize(
            pointViewWithIntensities(*points), pose, voxels.frame.of(law));
        !status.ok())
      throw std::runtime_error("scan '" + scan.name + "': " + status.message());
  const io::VoxelFrame& counts = voxels.frame.of(Law::Count);
  if (counts.keys != voxels.frame.of(Law::Native).keys)
    throw std::logic_error("the voxels of two laws differ");
  voxels.voxel_of_return.clear();
  for (const pcl::PointXYZI& point : *scan.returns)
    voxels.voxel_of_return.push_back(voxelOf(point, counts));
  judgeVoxels(scan, voxels);
}

} // namespace noise
} // namespace pcl_ext
