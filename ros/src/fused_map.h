#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include <octomap/OcTree.h>

#include <cstddef>
#include <optional>
#include <string>

namespace pcl_ext_ros {

/** \brief The OctoMap that the voxels of all streams are put into, and its file. For one
 * thread at a time. */
class FusedMap {
public:
  /** \brief An empty map.
   * \param[in] resolution edge of its smallest nodes, metres
   * \param[in] full_intensity as of insertVoxels
   * \param[in] path file to write to
   */
  FusedMap(double resolution, double full_intensity, std::string path);

  /** \brief Puts one frame of one stream into the map; see insertVoxels. completeRound()
   * follows behind the frames of all streams. */
  void
  insert(const pcl_ext::io::VoxelFrame& frame,
         const std::optional<octomap::point3d>& sensor_origin);

  /** \brief Tells inner nodes what was put in, and makes one node of eight that say the
   * same, behind which the map is several times smaller. */
  void
  completeRound();

  /** \brief The file that a map is written to until it is whole. */
  static std::string
  unfinishedPath(const std::string& path)
  {
    return path + ".part";
  }

  /** \brief What came of writing. */
  struct Written {
    bool ok = false;
    std::string message; ///< one sentence
  };

  /** \brief Writes the map as .ot; a file that is there is replaced when the new one is
   * whole. */
  Written
  write() const;

  /** \brief Nodes of the map. */
  std::size_t
  size() const
  {
    return tree_.size();
  }

private:
  octomap::OcTree tree_;
  float full_intensity_;
  std::string path_;
};

} // namespace pcl_ext_ros
