#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/morton_key.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace published {

/** \brief The branch nodes of one level of an octree, in Morton order. */
struct OccupancyLevel {
  std::vector<std::uint64_t> nodes;    ///< upper bits of the voxels' Morton keys
  std::vector<std::uint8_t> occupancy; ///< bit i set: child i is occupied

  std::size_t
  size() const
  {
    return nodes.size();
  }

  void
  clear()
  {
    nodes.clear();
    occupancy.clear();
  }

  void
  push(std::uint64_t node, std::uint8_t bits)
  {
    nodes.push_back(node);
    occupancy.push_back(bits);
  }
};

/** \brief The children that an occupancy byte names, in ascending order. */
struct ChildList {
  std::uint8_t count = 0;
  std::array<std::uint8_t, 8> children{}; ///< the first `count` are valid, the others 0
};

namespace detail {

constexpr std::array<ChildList, 256>
makeChildLists()
{
  std::array<ChildList, 256> lists{};
  for (unsigned int occupancy = 0; occupancy < 256; ++occupancy)
    for (unsigned int child = 0; child < 8; ++child)
      if ((occupancy >> child & 1) != 0)
        lists[occupancy].children[lists[occupancy].count++] =
            static_cast<std::uint8_t>(child);
  return lists;
}

inline constexpr std::array<ChildList, 256> child_lists = makeChildLists();

} // namespace detail

/** \brief The children of an occupancy byte, looked up. */
inline const ChildList&
childrenOf(std::uint8_t occupancy)
{
  return detail::child_lists[occupancy];
}

/** \brief An octree as its levels of occupancy bytes, without pointers.
 *
 * Level 0 is the root alone; the children on the last level are voxels. An empty octree
 * has no nodes at all.
 */
class OccupancyTree {
public:
  /** \brief Makes the octree of a set of voxels.
   * \param[in] keys Morton keys, strictly ascending, below 8^depth
   * \param[in] depth number of levels, 1..max_grid_depth
   */
  void
  build(const std::vector<std::uint64_t>& keys, unsigned int depth);

  /** \brief An octree of a number of levels, all of them empty; to be filled from the
   * top. */
  void
  reset(unsigned int depth);

  unsigned int
  depth() const
  {
    return depth_;
  }

  const OccupancyLevel&
  level(unsigned int index) const
  {
    return levels_[index];
  }

  OccupancyLevel&
  level(unsigned int index)
  {
    return levels_[index];
  }

private:
  unsigned int depth_ = 0;
  std::array<OccupancyLevel, max_grid_depth> levels_;
};

/** \brief Branch nodes that a decoder accepts in a frame of so many voxels: one a level for
 * each voxel while voxels are few, an average of two each when they are many; and one a
 * level more, for the branch without voxels that an octree of PCL may have grown from. */
std::size_t
maxBranchNodes(std::uint64_t voxels, unsigned int depth);

/** \brief Walks along a level in Morton order and tells the occupancy of the nodes that
 * are asked for, in ascending order; 0 for a node that is not there. */
class OccupancyCursor {
public:
  OccupancyCursor() = default;
  explicit OccupancyCursor(const OccupancyLevel& level) : level_(&level) {}

  std::uint8_t
  occupancyOf(std::uint64_t node)
  {
    if (level_ == nullptr)
      return 0;
    const std::size_t size = level_->nodes.size();
    while (position_ < size && level_->nodes[position_] < node)
      ++position_;
    return position_ < size && level_->nodes[position_] == node
               ? level_->occupancy[position_]
               : std::uint8_t{0};
  }

private:
  const OccupancyLevel* level_ = nullptr;
  std::size_t position_ = 0;
};

} // namespace published
} // namespace io
} // namespace pcl_ext
