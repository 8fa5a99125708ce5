#include "fused_map.h"

#include <pcl_ext/nodes/octomap_insertion.h>

#include <filesystem>
#include <fstream>
#include <utility>

namespace pcl_ext_ros {

FusedMap::FusedMap(double resolution, double full_intensity, std::string path)
: tree_(resolution)
, full_intensity_(static_cast<float>(full_intensity))
, path_(std::move(path))
{}

void
FusedMap::insert(const pcl_ext::io::VoxelFrame& frame,
                 const std::optional<octomap::point3d>& sensor_origin)
{
  constexpr bool lazily = true; // several streams go in before completeRound()
  pcl_ext::nodes::insertVoxels(frame, full_intensity_, sensor_origin, tree_, lazily);
}

void
FusedMap::completeRound()
{
  tree_.updateInnerOccupancy();
  tree_.prune();
}

FusedMap::Written
FusedMap::write() const
{
  // Beside the file, so that it can take its place.
  const std::string unfinished = unfinishedPath(path_);
  bool is_whole = false;
  {
    // Not by name: OctoMap does not tell whether the file took all bytes.
    std::ofstream stream(unfinished, std::ios::binary);
    is_whole = stream.is_open() && tree_.write(stream) && stream.flush().good();
  }
  std::error_code failure;
  if (is_whole)
    std::filesystem::rename(unfinished, path_, failure);
  if (is_whole && !failure)
    return {true, std::to_string(tree_.size()) + " nodes written to " + path_};
  std::filesystem::remove(unfinished, failure);
  return {false, "The map could not be written to " + path_};
}

} // namespace pcl_ext_ros
