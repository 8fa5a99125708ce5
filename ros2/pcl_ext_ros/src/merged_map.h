#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/nodes/central_node.h>

#include <octomap/octomap_types.h>
#include <octomap/OcTree.h>

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>

namespace pcl_ext_ros {

/** \brief The OctoMap of the voxels of all streams, and its file. For one thread at a
 * time. */
class MergedMap {
public:
  /** \brief Finds the position of a stream's sensor at a time; none: no rays are taken. */
  using FindSensor =
      std::function<std::optional<octomap::point3d>(pcl_ext::nodes::Time)>;

  /** \brief Outcome of writing. */
  struct Written {
    bool ok = false;
    std::string message; ///< one sentence
  };

  /** \brief An empty map.
   * \param[in] resolution metres
   * \param[in] full_intensity see pcl_ext::nodes::insertVoxels
   */
  MergedMap(double resolution, double full_intensity);

  /** \brief Inserts the latest frame of a stream, unless it is in the map already. Call
   * completeRound() after the frames of all streams.
   * \param[in] stream name in the central node
   * \param[in] find_sensor may be empty: no rays are taken
   * \param[in] central_node that decodes the stream
   */
  void
  insertLatest(const std::string& stream,
               const FindSensor& find_sensor,
               const pcl_ext::nodes::CentralNode& central_node);

  /** \brief Updates the inner nodes and prunes the tree. */
  void
  completeRound();

  const octomap::OcTree&
  tree() const
  {
    return tree_;
  }

  /** \brief Writes the map as .ot. An existing file is replaced when the new one is
   * complete. */
  Written
  write(const std::string& path) const;

  /** \brief What prevents writing to a file; empty if nothing. */
  static std::string
  faultOf(const std::string& path);

private:
  const float full_intensity_;
  octomap::OcTree tree_;
  std::map<std::string, std::size_t> last_frames_; // number of the last one, by stream
  pcl_ext::io::VoxelFrame voxels_;                 // keeps its memory
};

} // namespace pcl_ext_ros
