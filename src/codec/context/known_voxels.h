#pragma once

#include "codec/context/frame.h"
#include "codec/context/history.h"
#include "codec/context/models.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief Models of known voxels (doc/bitstream_context.md, "Known voxels"). */
struct KnownVoxelModels {
  explicit KnownVoxelModels(bool is_mixing)
  : voxel(is_mixing, 6, {1920, 7168, 4096, 5120, 2048, 4096}, 24)
  {}

  DecisionModel<6> voxel; ///< a known voxel is occupied
};

/** \brief Codes the occupancy of the known voxels, which have a record in the history, for
 * either direction.
 * \tparam CodingT SingleContextCoding or MixedContextCoding
 */
template <typename CodingT>
class KnownVoxelPass {
public:
  /** \brief A pass over one frame.
   * \param[in,out] frame after Frame::begin() or match()
   * \param[in] context of the frame
   */
  KnownVoxelPass(CodingT& coding,
                 KnownVoxelModels& models,
                 Frame& frame,
                 const FrameContext& context)
  : coding_(coding)
  , models_(models)
  , frame_(frame)
  , history_(context.history)
  , levels_(levelsAboveBlocks(context.grid_depth))
  , mean_shift_(context.history.fractionBits() -
                std::min(context.history.fractionBits(), 2u))
  {}

  /** \brief Codes the known voxels.
   * \return number of occupied ones
   */
  std::size_t
  run()
  {
    std::size_t voxels = 0;
    // A copy, which stays in registers.
    CodingT coding = coding_;
    for (std::size_t i = 0; i < history_.blocks().size(); ++i) {
      frame_.occupied[i] = codeBlock(coding, i, frame_.occupied[i]);
      voxels += bitCount(frame_.occupied[i]);
    }
    coding_ = coding;
    return voxels;
  }

private:
  using Contexts = DecisionModel<6>::Contexts;

  /** \brief Changes in a block and around it since the last frame, as far as they are
   * coded. */
  struct Surroundings {
    NeighbourCounts before; // neighbours in the last frame
    NeighbourCounts came;   // neighbours that are occupied now, but were not
    NeighbourCounts went;   // neighbours that were occupied, but are not now
    std::array<std::uint64_t, face_count> came_around{};
    std::array<std::uint64_t, face_count> went_around{};
    std::uint64_t came_here = 0;
    std::uint64_t went_here = 0;
    std::int32_t mean_error = 0; // running mean of decision - probability
  };

  std::uint64_t
  codeBlock(CodingT& coding, std::size_t index, std::uint64_t target)
  {
    const HistoryBlock& block = history_.blocks()[index];
    Surroundings around;
    if constexpr (CodingT::is_mixing)
      lookAround(index, around);
    std::uint64_t occupied = 0;
    std::size_t record = block.first_record;
    for (std::uint64_t cells = block.known; cells != 0; cells &= cells - 1, ++record) {
      const std::uint64_t cell = cells & (~cells + 1);
      Contexts contexts;
      contexts.ways[0] = recordContext(record);
      if constexpr (CodingT::is_mixing)
        addContexts(record, lowestBit(cells), occupied, around, contexts);
      const bool is_occupied =
          coding.code(models_.voxel, contexts, (target & cell) != 0);
      if (is_occupied)
        occupied |= cell;
      if constexpr (CodingT::is_mixing)
        update(block, record, cell, is_occupied, around);
    }
    return occupied;
  }

  /** \brief Context from the record alone: probability, last two frames, age and mean. */
  std::uint32_t
  recordContext(std::size_t record) const
  {
    const VoxelRecord& known = history_.records()[record];
    // By tables, as branches would be mispredicted.
    const std::uint32_t mean_class =
        mean_classes[std::min<std::uint32_t>(known.mean >> mean_shift_, 20)];
    return (((known.probability >> 11) * 4u + (known.recent & 3u)) * 3 +
            age_classes[std::min<std::uint32_t>(known.age, 5)]) *
               5 +
           mean_class;
  }

  /** \brief Classes of a mean in quarters of a point: bounds at 1.5, 2, 3 and 5 points. */
  static constexpr std::array<std::uint8_t, 21> mean_classes = {
      0, 0, 0, 0, 0, 0, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3, 3, 4};
  static constexpr std::array<std::uint8_t, 6> age_classes = {0, 0, 1, 1, 1, 2};

  /** \brief Mean number of a voxel, in sixteenths. */
  std::uint32_t
  meanOf(std::size_t record) const
  {
    return static_cast<std::uint32_t>(history_.records()[record].mean)
           << (4 - history_.fractionBits());
  }

  void
  lookAround(std::size_t index, Surroundings& around) const
  {
    const HistoryBlock& block = history_.blocks()[index];
    std::array<std::uint64_t, face_count> before{};
    for (std::size_t face = 0; face < face_count; ++face) {
      std::uint64_t key = 0;
      if (!neighbourBlock(block.key, face, levels_, key))
        continue;
      const std::uint32_t other = frame_.directory.find(key);
      if (other == BlockDirectory::not_found)
        continue;
      const HistoryBlock& neighbour = history_.blocks()[other];
      before[face] = neighbour.last;
      if (other < index) {
        around.came_around[face] = frame_.occupied[other] & ~neighbour.last;
        around.went_around[face] = neighbour.last & ~frame_.occupied[other];
      }
    }
    around.before = countNeighbours(block.last, before);
    around.came = countNeighbours(0, around.came_around);
    around.went = countNeighbours(0, around.went_around);
  }

  void
  update(const HistoryBlock& block,
         std::size_t record,
         std::uint64_t cell,
         bool is_occupied,
         Surroundings& around) const
  {
    const auto probability =
        static_cast<std::int32_t>(history_.records()[record].probability);
    around.mean_error +=
        ((is_occupied ? 0xffff - probability : -probability) - around.mean_error) >> 2;
    const bool was_occupied = (block.last & cell) != 0;
    if (is_occupied && !was_occupied) {
      around.came_here |= cell;
      around.came = countNeighbours(around.came_here, around.came_around);
    }
    if (!is_occupied && was_occupied) {
      around.went_here |= cell;
      around.went = countNeighbours(around.went_here, around.went_around);
    }
  }

  void
  addContexts(std::size_t record,
              unsigned int cell,
              std::uint64_t occupied,
              const Surroundings& around,
              Contexts& contexts) const
  {
    const VoxelRecord* const records = history_.records();
    const std::uint32_t probability = records[record].probability;
    const std::uint32_t recent = records[record].recent;
    const std::uint32_t age_class =
        age_classes[std::min<std::uint32_t>(records[record].age, 5)];
    const std::uint32_t mean = meanOf(record);
    const std::uint32_t before = around.before.of(cell);
    const std::uint32_t came = std::min(around.came.of(cell), 3u);
    const std::uint32_t went = std::min(around.went.of(cell), 3u);
    contexts.ways[1] =
        ((probability >> 11) * 7 + before) * 32 + came * 8 + went * 2 + (recent & 1);
    contexts.ways[2] = (recent * 4 + age_class) * 4 + (probability >> 14);
    const auto error_class = static_cast<std::uint32_t>(
        std::clamp((around.mean_error + 0x10000) >> 13, 0, 15));
    contexts.ways[3] = ((probability >> 11) * 16 + error_class) * 4 + (recent & 3);
    contexts.ways[4] = ((probability >> 12) * 16 + std::min(mean / 8, 15u)) * 8 +
                       std::min<std::uint32_t>(records[record].age / 4, 7u);
    contexts.ways[5] =
        (static_cast<std::uint32_t>(occupied >> (cell & ~7u) & 0xff) * 16) +
        (probability >> 12);
    contexts.weight_set = (probability >> 13) * 3 + age_class;
  }

  CodingT& coding_;
  KnownVoxelModels& models_;
  Frame& frame_;
  const History& history_;
  unsigned int levels_;
  unsigned int mean_shift_; // from a mean's fixed point to quarters
};

} // namespace context
} // namespace io
} // namespace pcl_ext
