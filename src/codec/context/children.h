#pragma once

#include "codec/context/models.h"
#include "codec/context/tiles.h"
#include "voxels/child_masks.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief Models of the children of octree nodes (doc/bitstream_context.md, "Children"). */
struct ChildModels {
  using Child = DecisionModel<5, 2>;

  explicit ChildModels(bool is_small)
  : child(is_small, 5, {64 * 256, 3 * 7 * 4 * 9 * 2, 64 * 8 * 3, 64 * 16 * 8, 256}, 7)
  {}

  Child child; ///< a child has new voxels
};

/** \brief Where a node is, as far as its children's contexts depend on it. */
enum class ParentKind : std::uint8_t {
  New,         ///< a new block, a part of one, or a branch above the blocks
  KnownOctant, ///< an octant of a block of the history
  KnownBlock   ///< a block of the history
};

/** \brief A node whose children are coded. */
struct ParentNode {
  ParentKind kind = ParentKind::New;
  unsigned int candidates = 0xff; ///< children that may have new voxels, a mask, not 0
  unsigned int target = 0;        ///< encoder only: those that have
};

/** \brief The nodes around a child that its contexts depend on. */
struct ChildSurroundings {
  std::uint32_t outside;  ///< state of the three across its faces outside its parent
  std::uint32_t siblings; ///< those before it that are present, below a 1
  std::uint32_t adjacent; ///< the siblings across its faces that are present, 3 bits
  std::uint32_t full;     ///< number of the six across its faces that are present
  std::uint32_t pending;  ///< number of those that are pending
};

/** \brief The window of a parent, prepared for its children. */
class ParentWindow {
public:
  explicit ParentWindow(const OctantWindow& window)
  : not_absent_(window.present | window.pending)
  , low_(window.present | (wallsOf(window.present) & ~window.pending))
  {}

  /** \param[in] child 0..7
   * \param[in] nodes the children that are present, a mask
   */
  PCL_EXT_ALWAYS_INLINE ChildSurroundings
  of(unsigned int child, unsigned int nodes) const
  {
    // Two bits a node: 3 present, 2 pending, 1 absent in a wall with present ones, 0.
    const std::array<std::uint8_t, 3>& places = window_places[child].faces;
    const std::uint32_t high = threeBits(not_absent_, places);
    const std::uint32_t low = threeBits(low_, places);
    ChildSurroundings around;
    around.outside = high * 8 + low;
    around.siblings = 1u << child | (nodes & ((1u << child) - 1));
    around.adjacent = (nodes >> (child ^ 4) & 1) << 2 |
                      (nodes >> (child ^ 2) & 1) << 1 | (nodes >> (child ^ 1) & 1);
    around.full = bit_counts[high & low] + bit_counts[around.adjacent];
    around.pending = bit_counts[high & ~low];
    return around;
  }

  /** \brief Which of the nodes across a child's edges and corner outside its parent's walls
   * are not absent, 4 bits. */
  std::uint32_t
  beyond(unsigned int child) const
  {
    const WindowPlaces& places = window_places[child];
    return threeBits(not_absent_, places.edges) << 1 |
           static_cast<std::uint32_t>(not_absent_ >> places.corner & 1);
  }

private:
  PCL_EXT_ALWAYS_INLINE static std::uint32_t
  threeBits(std::uint64_t nodes, const std::array<std::uint8_t, 3>& places)
  {
    return static_cast<std::uint32_t>((nodes >> places[0] & 1) << 2 |
                                      (nodes >> places[1] & 1) << 1 |
                                      (nodes >> places[2] & 1));
  }

  std::uint64_t not_absent_;
  std::uint64_t low_;
};

/** \brief Codes which children of a node, at least one, have new voxels.
 * \param[in] parent the node
 * \param[in] window the nodes around it
 * \return the children as a mask
 */
template <typename CodingT>
unsigned int
codeChildren(CodingT& coding,
             ChildModels& models,
             const ParentNode& parent,
             const OctantWindow& window)
{
  const ParentWindow around_parent(window);
  unsigned int children = 0;
  std::uint32_t found = 0;
  std::uint32_t left = child_masks.count[parent.candidates];
  for (unsigned int candidates = parent.candidates; candidates != 0;
       candidates &= candidates - 1) {
    --left;
    const unsigned int child = lowestBit(candidates);
    const bool is_implied = left == 0 && found == 0;
    if (!is_implied) {
      const ChildSurroundings around = around_parent.of(child, window.nodes | children);
      const std::uint32_t candidate_class =
          found == 0 ? 7 - left : std::min(6 + found, 8u);
      ChildModels::Child::Contexts contexts;
      contexts.ways[0] = around.outside * 256 + around.siblings;
      contexts.ways[1] =
          (((static_cast<std::uint32_t>(parent.kind) * 7 + around.full) * 4 +
            around.pending) *
               9 +
           candidate_class) *
              2 +
          (window.nodes >> child & 1);
      if constexpr (CodingT::is_small) {
        contexts.ways[2] =
            (around.outside * 8 + around.adjacent) * 3 + std::min(found, 2u);
        contexts.ways[3] =
            (around.outside * 16 + around_parent.beyond(child)) * 8 + child;
        contexts.ways[4] = around.siblings;
      }
      contexts.weight_set = around.full;
      if (!coding.code(models.child, contexts, (parent.target >> child & 1) != 0))
        continue;
    }
    ++found;
    children |= 1u << child;
  }
  return children;
}

} // namespace context
} // namespace io
} // namespace pcl_ext
