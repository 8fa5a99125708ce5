#include "merged_map.h"

#include <pcl_ext/nodes/octomap_insertion.h>

#include <filesystem>
#include <fstream>

namespace pcl_ext_ros {

namespace {

/** \brief Name of the file while the map is written. */
std::string
unfinishedPath(const std::string& path)
{
  return path + ".part";
}

} // namespace

MergedMap::MergedMap(double resolution, double full_intensity)
: full_intensity_(static_cast<float>(full_intensity)), tree_(resolution)
{}

void
MergedMap::insertLatest(const std::string& stream,
                        const FindSensor& find_sensor,
                        const pcl_ext::nodes::CentralNode& central_node)
{
  const auto frame = central_node.latestVoxels(stream, voxels_);
  std::size_t& last_frame = last_frames_[stream];
  // A frame that is inserted twice would count as further evidence.
  if (!frame || frame->number == last_frame)
    return;
  last_frame = frame->number;
  std::optional<octomap::point3d> origin;
  if (find_sensor)
    origin = find_sensor(frame->stamp);
  constexpr bool lazily = true; // completeRound() updates the inner nodes
  pcl_ext::nodes::insertVoxels(voxels_, full_intensity_, origin, tree_, lazily);
}

void
MergedMap::completeRound()
{
  tree_.updateInnerOccupancy();
  tree_.prune();
}

MergedMap::Written
MergedMap::write(const std::string& path) const
{
  const std::string unfinished = unfinishedPath(path);
  bool is_complete = false;
  {
    // By stream, as OctoMap's write by name does not report a full disk.
    std::ofstream stream(unfinished, std::ios::binary);
    is_complete = stream.is_open() && tree_.write(stream) && stream.flush().good();
  }
  std::error_code failure;
  if (is_complete)
    std::filesystem::rename(unfinished, path, failure);
  if (is_complete && !failure)
    return {true, std::to_string(tree_.size()) + " nodes written to " + path};
  std::filesystem::remove(unfinished, failure);
  return {false, "The map could not be written to " + path};
}

std::string
MergedMap::faultOf(const std::string& path)
{
  std::error_code failure;
  const bool exists = std::filesystem::exists(path, failure);
  if (!exists || std::filesystem::is_regular_file(path, failure)) {
    const std::string unfinished = unfinishedPath(path);
    if (std::ofstream(unfinished, std::ios::binary).is_open() &&
        std::filesystem::remove(unfinished, failure))
      return {};
  }
  return "map_path is '" + path +
         "'; it must be a file in a folder that can be written to";
}

} // namespace pcl_ext_ros
