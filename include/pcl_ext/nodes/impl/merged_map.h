// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/octomap_insertion.h>

#include <octomap/octomap_types.h>
#include <octomap/OcTree.h>

#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <system_error>

namespace pcl_ext::PCL_EXT_ABI::nodes::detail {

/** \brief The OctoMap of the voxels of all streams of a CentralNode, and its file. For
 * one thread at a time. Needs OctoMap, as insertVoxels does. */
class MergedMap {
public:
  /** \brief Finds the position of a stream's sensor at a time; none: no rays are
   * taken. */
  using FindSensor = std::function<std::optional<octomap::point3d>(Time)>;

  /** \brief Outcome of writing. */
  struct Written {
    bool ok = false;
    std::string message; ///< one sentence
  };

  /** \brief An empty map.
   * \param[in] resolution metres
   */
  explicit MergedMap(double resolution);

  /** \brief Inserts the latest frame of a stream, unless it is in the map already. Call
   * completeRound() after the frames of all streams.
   * \param[in] stream name in the central node
   * \param[in] full_intensity see insertVoxels; 0: each voxel is a hit
   * \param[in] find_sensor may be empty: no rays are taken
   * \param[in] central_node that decodes the stream
   * \return whether it was inserted
   */
  bool
  insertLatest(const std::string& stream,
               double full_intensity,
               const FindSensor& find_sensor,
               const CentralNode& central_node);

  /** \brief Updates the inner nodes and prunes the tree. */
  void
  completeRound();

  const octomap::OcTree&
  tree() const
  {
    return tree_;
  }

  /** \brief What of the frames is not in the map, one sentence; empty: nothing. */
  std::string
  faultOfFrames() const;

  /** \brief Writes the map as .ot. An existing file is replaced when the new one is
   * complete. */
  Written
  write(const std::string& path) const;

  /** \brief What prevents writing to a file; empty if nothing.
   * \param[in] option that names the file
   */
  static std::string
  faultOf(const std::string& option, const std::string& path);

private:
  /** \brief Name of the file while the map is written. */
  static std::string
  unfinishedPath(const std::string& path)
  {
    return path + ".part";
  }

  octomap::OcTree tree_;
  std::map<std::string, std::size_t> last_frames_; // number of the last one, by stream
  std::size_t left_out_ = 0; // voxels of all frames, as they are too far
  io::VoxelFrame voxels_;    // keeps its memory
};

inline MergedMap::MergedMap(double resolution) : tree_(resolution) {}

inline bool
MergedMap::insertLatest(const std::string& stream,
                        double full_intensity,
                        const FindSensor& find_sensor,
                        const CentralNode& central_node)
{
  const auto frame = central_node.latestVoxels(stream, voxels_);
  std::size_t& last_frame = last_frames_[stream];
  // A frame that is inserted twice would count as further evidence.
  if (!frame || frame->number == last_frame)
    return false;
  last_frame = frame->number;
  std::optional<octomap::point3d> origin;
  if (find_sensor)
    origin = find_sensor(frame->stamp);
  if (full_intensity == 0.0) {
    voxels_.intensity_scale.bits = 0;
    voxels_.intensities.clear();
    voxels_.depth_model.reset();
  }
  constexpr bool lazily = true; // completeRound() updates the inner nodes
  left_out_ +=
      insertVoxels(voxels_, static_cast<float>(full_intensity), origin, tree_, lazily);
  return true;
}

inline void
MergedMap::completeRound()
{
  tree_.updateInnerOccupancy();
  tree_.prune();
}

inline std::string
MergedMap::faultOfFrames() const
{
  if (left_out_ == 0)
    return {};
  return "Voxels of frames are not in the map, " + std::to_string(left_out_) +
         " in all, as they are more than 32768 voxels from the origin: set a larger "
         "resolution";
}

inline MergedMap::Written
MergedMap::write(const std::string& path) const
{
  const std::string unfinished = unfinishedPath(path);
  bool is_complete = false;
  std::error_code failure;
  {
    // By stream, as OctoMap's write by name does not report a full disk.
    errno = 0;
    std::ofstream stream(unfinished, std::ios::binary);
    is_complete = stream.is_open() && tree_.write(stream) && stream.flush().good();
    if (!is_complete)
      failure = {errno, std::generic_category()};
  }
  if (is_complete)
    std::filesystem::rename(unfinished, path, failure);
  if (is_complete && !failure)
    return {true, std::to_string(tree_.size()) + " nodes written to " + path};
  std::error_code ignored;
  std::filesystem::remove(unfinished, ignored);
  return {false, "The map could not be written to " + path + ": " + failure.message()};
}

inline std::string
MergedMap::faultOf(const std::string& option, const std::string& path)
{
  if (std::filesystem::path(path).extension() == ".bt")
    return option + " is '" + path +
           "'; it must not end in .bt, as the map is written with its odds, as .ot";
  std::error_code failure;
  const bool exists = std::filesystem::exists(path, failure);
  if (!exists || std::filesystem::is_regular_file(path, failure)) {
    const std::string unfinished = unfinishedPath(path);
    if (std::ofstream(unfinished, std::ios::binary).is_open()) {
      std::filesystem::remove(unfinished, failure); // if another program has not
      return {};
    }
  }
  return option + " is '" + path +
         "'; it must be a file in a folder that can be written to";
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes::detail
