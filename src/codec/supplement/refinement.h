// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/rans/nibble_model.h"
#include "simd/bit_operations.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace supplement {

/** \brief Models of the voxels within coarse voxels (doc/bitstream_supplement.md,
 * "Refinement"). */
struct RefinementModels {
  static constexpr std::size_t largest_count = 14;
  static constexpr std::size_t count_classes = 16;

  /** \brief A coarse voxel's number of voxels, by that of the coarse voxel before. */
  std::array<rans::NibbleModel, count_classes> count;
  /** \brief How many of 2..14 voxels are in the lower half, by axis. */
  std::array<std::array<rans::NibbleModel, largest_count + 1>, 3> split;
  /** \brief How many of more voxels: 0 none, 1 all, 2 some; by axis. */
  std::array<rans::NibbleModel, 3> split_kind;
  /** \brief Bits of a single voxel: by level and axis, the same bit of the single voxel
   * before, and whether all higher bits of the axis were as there. */
  std::array<std::array<rans::BitModel, 4>, 63> single;
};

/** \brief Codes the voxels of coarse voxels, each a cube of 2^levels voxels along its
 * axes, for either direction.
 *
 * A coarse voxel is divided in half along x, y and z in turn, and the number of voxels
 * in the lower half is coded, until a single voxel is left, whose remaining bits
 * follow.
 * \tparam CodingT a NumberCoding
 */
template <typename CodingT>
class RefinementPass {
public:
  /** \brief A pass over one frame.
   * \param[in] levels of a coarse voxel, 1..20
   * \param[in] models_singles whether the bits of single voxels have models, which
   * takes fewer bytes and more time; else they are raw
   */
  RefinementPass(RefinementModels& models, unsigned int levels, bool models_singles)
  : models_(models), coarse_voxel_bits_(3 * levels), models_singles_(models_singles)
  {}

  /** \brief Codes the voxels.
   * \param[in,out] coding of the frame
   * \param[in] coarse_voxels keys of the coarse voxels, ascending
   * \param[in] voxel_count number of voxels of all coarse voxels, at least one of each
   * \param[in,out] keys of the voxels, ascending; the decoder fills them
   * \return false if what was decoded are no voxels, or not that many
   */
  template <class KeysT>
  bool
  run(CodingT& coding,
      const std::vector<std::uint64_t>& coarse_voxels,
      std::size_t voxel_count,
      KeysT& keys)
  {
    if constexpr (CodingT::is_decoder)
      keys.resize(voxel_count);
    CodingT local = coding; // in registers
    Key* key = keys.data();
    Key* const keys_end = key + voxel_count;
    std::size_t count_class = 0;
    for (std::size_t i = 0; i < coarse_voxels.size(); ++i) {
      const std::uint64_t first_key = coarse_voxels[i] << coarse_voxel_bits_;
      std::size_t count = 0;
      if constexpr (!CodingT::is_decoder) {
        const std::uint64_t last_key =
            first_key + ((std::uint64_t{1} << coarse_voxel_bits_) - 1);
        while (key + count != keys_end && key[count] <= last_key)
          ++count;
      }
      local.reserve(8);
      const std::uint64_t further =
          local.code(models_.count[count_class], static_cast<std::uint32_t>(count) - 1);
      const std::size_t coarse_voxels_after = coarse_voxels.size() - 1 - i;
      if (further >= static_cast<std::size_t>(keys_end - key) - coarse_voxels_after)
        return false;
      count = std::size_t{1} + static_cast<std::size_t>(further);
      if (!codeCoarseVoxel(local, {first_key, count, coarse_voxel_bits_}, key))
        return false;
      count_class = std::min(count, RefinementModels::count_classes) - 1;
      key += count;
    }
    coding = local;
    return key == keys_end;
  }

private:
  using Key =
      std::conditional_t<CodingT::is_decoder, std::uint64_t, const std::uint64_t>;

  /** \brief A part of a coarse voxel. */
  struct Part {
    std::uint64_t first_key;
    std::size_t count; ///< of its voxels, 1 or more
    unsigned int bits; ///< of a voxel's key within the part
  };

  /** \brief Codes the voxels of a coarse voxel.
   * \param[in] part the coarse voxel
   * \param[in,out] keys of its voxels
   */
  PCL_EXT_ALWAYS_INLINE bool
  codeCoarseVoxel(CodingT& coding, Part part, Key* keys)
  {
    std::size_t waiting = 0; // upper halves whose lower ones have voxels, too
    for (;;) {
      while (part.count > 1) {
        if constexpr (CodingT::is_decoder)
          if ((part.bits < 32 && part.count > std::size_t{1} << part.bits) ||
              coding.isOverrun())
            return false;
        const std::uint64_t upper_key =
            part.first_key + (std::uint64_t{1} << --part.bits);
        std::size_t lower = 0;
        if constexpr (!CodingT::is_decoder)
          lower = countBelow(upper_key, keys, part.count);
        coding.reserve(16);
        lower = codeLowerCount(coding, part.bits % 3, part.count, lower);
        if (lower > part.count)
          return false;
        if (lower == 0) {
          part.first_key = upper_key;
          continue;
        }
        if (lower != part.count)
          waiting_[waiting++] = {upper_key, part.count - lower, part.bits};
        part.count = lower;
      }
      if (coding.isOverrun())
        return false;
      codeSingle(coding, part, *keys++);
      if (waiting == 0)
        return !coding.isOverrun();
      part = waiting_[--waiting];
    }
  }

  /** \brief Number of voxels below a key. */
  static std::size_t
  countBelow(std::uint64_t key, const std::uint64_t* keys, std::size_t count)
  {
    constexpr std::size_t few = 8;
    if (count > few)
      return static_cast<std::size_t>(std::lower_bound(keys, keys + count, key) - keys);
    std::size_t below = 0;
    for (std::size_t i = 0; i < count; ++i) // without branches
      below += keys[i] < key ? 1 : 0;
    return below;
  }

  /** \brief How many of several voxels are in the lower half. */
  PCL_EXT_ALWAYS_INLINE std::size_t
  codeLowerCount(CodingT& coding,
                 unsigned int axis,
                 std::size_t count,
                 std::size_t lower)
  {
    if (count <= RefinementModels::largest_count)
      return static_cast<std::size_t>(std::min<std::uint64_t>(
          coding.code(models_.split[axis][count], static_cast<std::uint32_t>(lower)),
          count + 1));
    const std::uint64_t kind = coding.code(models_.split_kind[axis],
                                           lower == 0       ? 0
                                           : lower == count ? 1
                                                            : 2);
    if (kind < 2)
      return kind == 0 ? 0 : count;
    unsigned int bits = 1;
    while (count >> bits != 0)
      ++bits;
    return static_cast<std::size_t>(coding.codeBits(lower, bits));
  }

  /** \brief The bits of a voxel that is alone in its part. */
  PCL_EXT_ALWAYS_INLINE void
  codeSingle(CodingT& coding, const Part& part, Key& voxel)
  {
    coding.reserve(64);
    std::uint64_t key = CodingT::is_decoder ? 0 : voxel - part.first_key;
    key = models_singles_ ? codeModelled(coding, key, part.bits)
                          : coding.codeBits(key, part.bits);
    if constexpr (CodingT::is_decoder)
      voxel = part.first_key + key;
  }

  PCL_EXT_ALWAYS_INLINE std::uint64_t
  codeModelled(CodingT& coding, std::uint64_t key, unsigned int bits)
  {
    std::uint64_t coded = 0;
    unsigned int same_axes = 7; // those all of whose higher bits are last_single_'s
    for (unsigned int bit = bits; bit-- > 0;) {
      const unsigned int axis = 1u << bit % 3;
      const auto last = static_cast<unsigned int>(last_single_ >> bit & 1);
      const unsigned int is_same = (same_axes & axis) != 0 ? 1 : 0;
      const bool decision = coding.codeBit(models_.single[bit][2 * last + is_same],
                                           (key >> bit & 1) != 0);
      coded = coded << 1 | (decision ? 1 : 0);
      if (decision != (last != 0))
        same_axes &= ~axis;
    }
    last_single_ = (last_single_ & ~((std::uint64_t{1} << bits) - 1)) | coded;
    return coded;
  }

  RefinementModels& models_;
  unsigned int coarse_voxel_bits_;
  bool models_singles_;
  std::uint64_t last_single_ = 0;
  std::array<Part, 60> waiting_{}; // one at most of each bit of a coarse voxel
};

} // namespace supplement
} // namespace pcl_ext::PCL_EXT_ABI::io
