#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/nodes/central_node.h>

#include "node_parameters.h"
#include "transform_lookup.h"

#include <octomap/OcTree.h>

#include <cstddef>
#include <map>
#include <optional>
#include <string>

namespace pcl_ext_ros {

/** \brief The OctoMap of the voxels of all streams, and its file. For one thread at a
 * time. */
class MergedMap {
public:
  /** \brief Whether the map takes rays from the sensors whose frame is known. */
  enum class Rays { Yes, No };

  /** \brief Outcome of writing. */
  struct Written {
    bool ok = false;
    std::string message; ///< one sentence
  };

  /** \brief An empty map.
   * \param[in] parameters of the decompressor; the path is not empty
   */
  explicit MergedMap(const DecompressorParameters& parameters);

  /** \brief Inserts the latest frame of a stream, unless it is in the map already; see
   * pcl_ext::nodes::insertVoxels. Call completeRound() after the frames of all streams.
   * \param[in] stream name in the central node
   * \param[in] sensor_frame TF frame of its sensor; empty: no rays
   * \param[in] rays whether to take rays
   * \param[in] central_node that decodes the stream
   */
  void
  insertLatest(const std::string& stream,
               const std::string& sensor_frame,
               Rays rays,
               const pcl_ext::nodes::CentralNode& central_node);

  /** \brief Updates the inner nodes and prunes the tree. */
  void
  completeRound();

  /** \brief Writes the map as .ot. An existing file is replaced when the new one is
   * complete. */
  Written
  write() const;

  /** \brief Number of nodes. */
  std::size_t
  size() const
  {
    return tree_.size();
  }

  /** \brief Name of the file while the map is written. */
  static std::string
  unfinishedPath(const std::string& path)
  {
    return path + ".part";
  }

private:
  /** \brief Position of a sensor; nothing if TF has no transform. */
  std::optional<octomap::point3d>
  findOrigin(const std::string& sensor_frame, pcl_ext::nodes::Time stamp) const;

  MapParameters parameters_;
  octomap::OcTree tree_;
  std::optional<TransformLookup> transforms_;      // where a stream has a sensor_frame
  std::map<std::string, std::size_t> last_frames_; // number of the last one, by stream
  pcl_ext::io::VoxelFrame voxels_;                 // keeps its memory
};

} // namespace pcl_ext_ros
