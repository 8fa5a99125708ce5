#include "fast_occupancy.h"

#include "block_octants.h"
#include "nibble_rans.h"
#include "voxel_block.h"

#include <algorithm>
#include <limits>

namespace pcl_ext {
namespace io {

namespace {

constexpr std::uint64_t no_key = std::numeric_limits<std::uint64_t>::max();

// Symbols of an octant's or a cell's place; up to them it is the rank of a single one.
constexpr unsigned int several_octants = 9;
constexpr unsigned int several_cells = 8;

/** \brief Codes a byte as two nibbles. */
template <class Coder, std::size_t contexts>
unsigned int
codeByte(Coder& coder,
         ByteModels<contexts>& models,
         unsigned int context,
         unsigned int byte)
{
  const unsigned int low = coder.code(models.low[context], byte & 15);
  return low | coder.code(models.high[low], byte >> 4) << 4;
}

} // namespace

void
FastOccupancy::match(const FastHistory& before,
                     const std::vector<std::uint64_t>& keys,
                     FastFrame& frame)
{
  frame.resizeBlocks(keys.size() + 1);
  frame.block_of.resize(keys.size());
  frame.cell_of.resize(keys.size());
  std::uint64_t key = keys.front() >> block_key_bits;
  std::uint64_t mask = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const std::uint64_t next = keys[i] >> block_key_bits;
    const std::uint64_t cell = keys[i] & (block_cells - 1);
    // Without a branch: every third voxel or so begins a block.
    const std::uint64_t is_other = next != key ? 1 : 0;
    frame.keys[count] = key;
    frame.masks[count] = mask;
    count += is_other;
    mask = (mask & (is_other - 1)) | std::uint64_t{1} << cell;
    key = next;
    frame.block_of[i] = static_cast<std::uint32_t>(count);
    frame.cell_of[i] = static_cast<std::uint8_t>(cell);
  }
  frame.keys[count] = key;
  frame.masks[count++] = mask;
  frame.keys[count] = no_key;
  frame.occupied.resize(before.known.size());
  frame.new_keys.clear();
  frame.new_masks.clear();
  std::size_t now = 0;
  for (std::size_t i = 0; i < before.keys.size(); ++i) {
    for (; frame.keys[now] < before.keys[i]; ++now) {
      frame.new_keys.push_back(frame.keys[now]);
      frame.new_masks.push_back(frame.masks[now]);
    }
    const std::uint64_t is_same = frame.keys[now] == before.keys[i] ? 1 : 0;
    frame.occupied[before.numbers[i]] = frame.masks[now] & (0 - is_same);
    now += is_same;
  }
  for (; now < count; ++now) {
    frame.new_keys.push_back(frame.keys[now]);
    frame.new_masks.push_back(frame.masks[now]);
  }
}

template <class Coder>
bool
FastOccupancy::code(Coder& coder,
                    FastModels& models,
                    const FastHistory& before,
                    FastHistory& after,
                    std::vector<std::uint16_t>& moments,
                    FastFrame& frame)
{
  found_voxels_ = 0;
  if (Coder::is_decoder)
    frame.occupied.assign(before.known.size(), 0);
  return codeKnownVoxels(coder, models, before, after, frame) &&
         codeNewOctants(coder, models, before, frame) &&
         codeOctantMasks(coder, models, before, frame) &&
         codeNewCells(coder, models, before, frame) &&
         codeNewBlocks(coder, models, frame) &&
         (!Coder::is_decoder || found_voxels_ == frame.voxel_count) &&
         learnBlocks(before, after, moments, frame);
}

template <class Coder>
bool
FastOccupancy::codeKnownVoxels(Coder& coder,
                               FastModels& models,
                               const FastHistory& before,
                               FastHistory& after,
                               FastFrame& frame)
{
  // A bucket has room for all of those that it may be filled from.
  std::array<std::uint32_t, voxel_past::count> room{};
  std::size_t known = 0;
  for (unsigned int past = 1; past < voxel_past::count; ++past) {
    room[voxel_past::next(past, 0)] += before.size[past];
    room[voxel_past::next(past, 1)] += before.size[past];
    known += before.size[past];
  }
  std::uint32_t first = 0;
  for (std::size_t past = 0; past < voxel_past::count; ++past) {
    after.first[past] = first;
    first += room[past];
  }
  after.size.fill(0);
  // One more: a voxel is written to both buckets and stays in one.
  ensureSize(after.places, first + 1);
  coder.expect(known / 4 + 3 * voxel_past::count);
  for (unsigned int past = 1; past < voxel_past::count; ++past)
    if (before.size[past] != 0 &&
        !splitBucket(coder, models, past, before, after, frame))
      return false;
  return true;
}

template <class Coder>
bool
FastOccupancy::splitBucket(Coder& coder_now,
                           FastModels& models,
                           unsigned int past,
                           const FastHistory& before,
                           FastHistory& after,
                           FastFrame& frame)
{
  Coder coder = coder_now; // in registers
  std::uint64_t* const occupied = frame.occupied.data();
  const auto isOccupied = [&](VoxelPlace place) {
    return static_cast<unsigned int>(
        occupied[place / block_cells] >> (place % block_cells) & 1);
  };
  const unsigned int past_if_empty = voxel_past::next(past, 0);
  const unsigned int past_if_occupied = voxel_past::next(past, 1);
  VoxelPlace* const bucket_if_empty = after.places.data() + after.first[past_if_empty];
  VoxelPlace* const bucket_if_occupied =
      after.places.data() + after.first[past_if_occupied];
  VoxelPlace* if_empty = bucket_if_empty + after.size[past_if_empty];
  VoxelPlace* if_occupied = bucket_if_occupied + after.size[past_if_occupied];
  const VoxelPlace* const first_occupied = if_occupied;
  const auto put = [&](VoxelPlace place, unsigned int bit) {
    *if_empty = place;
    *if_occupied = place;
    if_empty += 1 - bit;
    if_occupied += bit;
  };
  const VoxelPlace* from = before.places.data() + before.first[past];
  const std::size_t count = before.size[past];
  NibbleModel& model = models.known[past];
  for (std::size_t i = 0; i < count / 4; ++i, from += 4) {
    unsigned int nibble = 0;
    if (!Coder::is_decoder)
      for (unsigned int k = 0; k < 4; ++k)
        nibble |= isOccupied(from[k]) << k;
    nibble = coder.code(model, nibble);
    for (unsigned int k = 0; k < 4; ++k)
      put(from[k], nibble >> k & 1);
    if (coder.isOverrun())
      return false;
  }
  for (std::size_t i = 0; i < count % 4; ++i, ++from) {
    unsigned int bit = Coder::is_decoder ? 0 : isOccupied(*from);
    bit = coder.code(models.known_rest[past], bit);
    put(*from, bit);
  }
  found_voxels_ += static_cast<std::size_t>(if_occupied - first_occupied);
  if (Coder::is_decoder)
    for (const VoxelPlace* place = first_occupied; place != if_occupied; ++place)
      occupied[*place / block_cells] |= std::uint64_t{1} << (*place % block_cells);
  after.size[past_if_empty] = static_cast<std::uint32_t>(if_empty - bucket_if_empty);
  after.size[past_if_occupied] =
      static_cast<std::uint32_t>(if_occupied - bucket_if_occupied);
  coder_now = coder;
  return !coder.isOverrun();
}

template <class Coder>
bool
FastOccupancy::codeNewOctants(Coder& coder_now,
                              FastModels& models,
                              const FastHistory& before,
                              FastFrame& frame)
{
  const std::size_t count = before.keys.size();
  coder_now.expect(count);
  Coder coder = coder_now;
  ensureSize(is_renewed_, count);
  ensureSize(renewed_blocks_, count + 1);
  ensureSize(octant_symbols_, count + 1);
  // Pointers of its own: a byte stored might be a vector's, for all the compiler knows.
  const std::uint32_t* const numbers = before.numbers.data();
  const std::uint8_t* const activity = before.activity.data();
  const std::uint64_t* const all_known = before.known.data();
  const std::uint64_t* const occupied = frame.occupied.data();
  std::uint8_t* const is_renewed_of = is_renewed_.data();
  std::uint32_t* const blocks = renewed_blocks_.data();
  std::uint8_t* const symbols = octant_symbols_.data();
  NibbleModel* const octant_models = models.octant.data();
  std::size_t renewed = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t number = numbers[i];
    std::uint64_t known_occupied = occupied[number];
    unsigned int symbol = 0;
    if (!Coder::is_decoder) {
      const std::uint64_t known = all_known[number];
      const unsigned int octants = occupiedOctants(known_occupied & ~known);
      known_occupied &= known;
      // Without a branch: every third block or so has new voxels.
      const unsigned int is_single = (octants & (octants - 1)) == 0 ? 1 : 0;
      const unsigned int rank =
          child_masks
              .rank[occupiedOctants(known_occupied)][lowestCell(octants | 256) % 8];
      symbol = ((1 + rank) & (0 - is_single)) | (several_octants & (is_single - 1));
      symbol &= 0u - static_cast<unsigned int>(octants != 0);
    }
    const unsigned int context = activity[i] * 2u + (known_occupied == 0 ? 1 : 0);
    symbol = coder.code(octant_models[context], symbol);
    const unsigned int is_renewed = symbol != 0 ? 1 : 0;
    is_renewed_of[i] = static_cast<std::uint8_t>(is_renewed);
    blocks[renewed] = static_cast<std::uint32_t>(i);
    symbols[renewed] = static_cast<std::uint8_t>(symbol);
    renewed += is_renewed;
    if (coder.isOverrun())
      return false;
  }
  renewed_blocks_.resize(renewed);
  coder_now = coder;
  return true;
}

template <class Coder>
bool
FastOccupancy::codeOctantMasks(Coder& coder_now,
                               FastModels& models,
                               const FastHistory& before,
                               FastFrame& frame)
{
  coder_now.expect(2 * renewed_blocks_.size());
  Coder coder = coder_now;
  // What is gone of a vector's length does not count when it grows.
  if (octants_.capacity() < 8 * renewed_blocks_.size())
    octants_.reserve(10 * renewed_blocks_.size());
  octants_.resize(8 * renewed_blocks_.size());
  VoxelPlace* octant = octants_.data();
  for (std::size_t i = 0; i < renewed_blocks_.size(); ++i) {
    const std::uint32_t number = before.numbers[renewed_blocks_[i]];
    const unsigned int symbol = octant_symbols_[i];
    const std::uint64_t occupied = frame.occupied[number];
    unsigned int mask = 0;
    if (Coder::is_decoder) {
      if (symbol > several_octants)
        return false;
      if (symbol < several_octants)
        mask = 1u << child_masks.by_neighbours[occupiedOctants(occupied)][symbol - 1];
    }
    else {
      mask = occupiedOctants(occupied & ~before.known[number]);
    }
    if (symbol == several_octants) {
      mask = codeByte(coder, models.octants, 0, mask);
      if (Coder::is_decoder && (child_masks.count[mask] < 2 || coder.isOverrun()))
        return false;
    }
    for (; mask != 0; mask &= mask - 1)
      *octant++ = number * block_cells + 8 * lowestCell(mask);
  }
  octants_.resize(static_cast<std::size_t>(octant - octants_.data()));
  coder_now = coder;
  return true;
}

template <class Coder>
bool
FastOccupancy::codeNewCells(Coder& coder_now,
                            FastModels& models,
                            const FastHistory& before,
                            FastFrame& frame)
{
  coder_now.expect(3 * octants_.size());
  Coder coder = coder_now;
  for (const VoxelPlace octant : octants_) {
    const std::uint32_t number = octant / block_cells;
    const unsigned int shift = octant % block_cells;
    const std::uint64_t known = before.known[number];
    const std::uint64_t occupied = frame.occupied[number];
    // What is coded by now: the known cells and the octants below.
    const std::uint64_t coded = occupied & (known | ((std::uint64_t{1} << shift) - 1));
    const auto open = static_cast<unsigned int>(~known >> shift & 0xff);
    const unsigned int near =
        static_cast<unsigned int>(cellsBeside(coded) >> shift) & open;
    const unsigned int far = open & ~near;
    const unsigned int near_count = child_masks.count[near];
    const unsigned int open_count = child_masks.count[open];
    unsigned int cells = 0;
    unsigned int rank = 0;
    if (!Coder::is_decoder) {
      cells = static_cast<unsigned int>(occupied >> shift) & open;
      const unsigned int below = (cells - 1) & 0xff;
      rank = (cells & near) != 0 ? child_masks.count[near & below]
                                 : near_count + child_masks.count[far & below];
      rank = (cells & below) != 0 ? several_cells : rank;
    }
    const unsigned int context = std::min(near_count, 7u) * 3 + (open_count == 8  ? 0
                                                                 : open_count > 4 ? 1
                                                                                  : 2);
    rank = coder.code(models.cell[context], rank);
    if (rank >= several_cells) {
      cells = codeByte(coder, models.cells, 0, cells);
      if (Coder::is_decoder && (rank > several_cells || child_masks.count[cells] < 2 ||
                                (cells & ~open) != 0))
        return false;
    }
    else if (Coder::is_decoder) {
      if (rank >= open_count)
        return false;
      cells = 1u << (rank < near_count ? child_masks.children[near][rank]
                                       : child_masks.children[far][rank - near_count]);
    }
    if (Coder::is_decoder) {
      frame.occupied[number] = occupied | std::uint64_t{cells} << shift;
      found_voxels_ += child_masks.count[cells];
      if (coder.isOverrun())
        return false;
    }
  }
  coder_now = coder;
  return found_voxels_ <= frame.voxel_count;
}

/** \brief For an encoder: the masks of all nodes above the new blocks. */
void
FastOccupancy::collectNodes(const FastFrame& frame)
{
  const unsigned int levels = levelsAboveBlocks(frame.depth);
  if (node_masks_.size() < levels)
    node_masks_.resize(levels);
  node_keys_.assign(frame.new_keys.begin(), frame.new_keys.end());
  for (unsigned int level = 0; level < levels; ++level) {
    std::vector<std::uint8_t>& masks = node_masks_[level];
    masks.clear();
    std::size_t count = 0;
    for (const std::uint64_t key : node_keys_) {
      // Parents take the place of their children, of which there are no fewer.
      if (count == 0 || node_keys_[count - 1] != key >> 3) {
        node_keys_[count++] = key >> 3;
        masks.push_back(0);
      }
      masks.back() = static_cast<std::uint8_t>(masks.back() | 1u << (key & 7));
    }
    node_keys_.resize(count);
  }
}

template <class Coder>
bool
FastOccupancy::codeNodes(Coder& coder_now,
                         FastModels& models,
                         unsigned int level,
                         FastFrame& frame)
{
  ByteModels<1>& node = models.node[std::min(level, 3u)];
  coder_now.expect(Coder::is_decoder ? 0 : 2 * node_masks_[level].size());
  Coder coder = coder_now;
  if (!Coder::is_decoder) {
    for (const std::uint8_t mask : node_masks_[level])
      codeByte(coder, node, 0, mask);
    coder_now = coder;
    return true;
  }
  // A block has a voxel at least, and a node a block.
  const std::size_t most = frame.voxel_count - found_voxels_;
  other_node_keys_.clear();
  for (const std::uint64_t key : node_keys_) {
    unsigned int mask = codeByte(coder, node, 0, 0);
    if (mask == 0 || coder.isOverrun() || other_node_keys_.size() > most)
      return false;
    for (; mask != 0; mask &= mask - 1)
      other_node_keys_.push_back(key << 3 | lowestCell(mask));
  }
  node_keys_.swap(other_node_keys_);
  coder_now = coder;
  return node_keys_.size() <= most;
}

template <class Coder>
bool
FastOccupancy::codeNewBlocks(Coder& coder, FastModels& models, FastFrame& frame)
{
  coder.expect(1);
  const unsigned int has_blocks = Coder::is_decoder || frame.new_keys.empty() ? 0 : 1;
  if (coder.code(models.has_new_blocks, has_blocks) == 0) {
    frame.new_keys.clear();
    frame.new_masks.clear();
    return true;
  }
  if (!Coder::is_decoder)
    collectNodes(frame);
  else
    node_keys_.assign(1, 0);
  for (unsigned int level = levelsAboveBlocks(frame.depth); level-- > 0;)
    if (!codeNodes(coder, models, level, frame))
      return false;
  if (Coder::is_decoder) {
    frame.new_keys.assign(node_keys_.begin(), node_keys_.end());
    frame.new_masks.assign(node_keys_.size(), 0);
  }
  return codeBlockCells(coder, models, frame);
}

template <class Coder>
bool
FastOccupancy::codeBlockCells(Coder& coder_now, FastModels& models, FastFrame& frame)
{
  const std::size_t count = frame.new_keys.size();
  coder_now.expect(18 * count);
  Coder coder = coder_now;
  const std::uint64_t outside = ~cellsInGrid(frame.depth);
  ByteModels<1>& octants_models = models.new_block_octants[frame.is_i_frame ? 1 : 0];
  ByteModels<16>& cells_models = models.new_block_cells[frame.is_i_frame ? 1 : 0];
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t mask = frame.new_masks[i];
    unsigned int octants = codeByte(
        coder, octants_models, 0, Coder::is_decoder ? 0 : occupiedOctants(mask));
    if (octants == 0)
      return false;
    std::uint64_t coded = 0;
    for (; octants != 0; octants &= octants - 1) {
      const unsigned int shift = 8 * lowestCell(octants);
      const auto near = static_cast<unsigned int>(cellsBeside(coded) >> shift & 15);
      const unsigned int cells = codeByte(
          coder, cells_models, near, static_cast<unsigned int>(mask >> shift & 0xff));
      if (cells == 0)
        return false;
      coded |= std::uint64_t{cells} << shift;
      found_voxels_ += child_masks.count[cells];
    }
    frame.new_masks[i] = coded;
    if (Coder::is_decoder && (coder.isOverrun() || (coded & outside) != 0 ||
                              found_voxels_ > frame.voxel_count))
      return false;
  }
  coder_now = coder;
  return true;
}

template bool
FastOccupancy::code(NibbleEncoder&,
                    FastModels&,
                    const FastHistory&,
                    FastHistory&,
                    std::vector<std::uint16_t>&,
                    FastFrame&);
template bool
FastOccupancy::code(NibbleDecoder&,
                    FastModels&,
                    const FastHistory&,
                    FastHistory&,
                    std::vector<std::uint16_t>&,
                    FastFrame&);

} // namespace io
} // namespace pcl_ext
