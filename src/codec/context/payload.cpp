#include "codec/context/payload.h"

namespace pcl_ext {
namespace io {
namespace context {

namespace {

// Where the knowledge of a record costs more time than an effort has for the bytes that
// it saves, as probabilities in 2^-16.
constexpr std::uint16_t forgotten_below_balanced = 3000;
constexpr std::uint16_t forgotten_below_small = 1000;

} // namespace

Payload::Payload(bool is_mixing)
: coder_(is_mixing)
, forgotten_below_(is_mixing ? forgotten_below_small : forgotten_below_balanced)
{}

FrameContext
Payload::contextOf(const VoxelFrame& frame, bool is_i_frame)
{
  empty_history_.clear(frame.intensity_scale.bits, forgotten_below_);
  return {is_i_frame ? empty_history_ : history_,
          is_i_frame,
          frame.grid.depth,
          frame.intensity_scale.bits,
          frame.depth_model ? &*frame.depth_model : nullptr};
}

PayloadSizes
Payload::encode(CodingWorkspace& /*work*/,
                const VoxelFrame& frame,
                bool is_i_frame,
                std::vector<std::uint8_t>& payload)
{
  const std::size_t begin = payload.size();
  PayloadSizes sizes;
  blocks_.assign(frame.keys);
  copyNumbers(frame.intensities, intensities_.symbols);
  const FrameContext context = contextOf(frame, is_i_frame);
  if (context.depth_model != nullptr) {
    intensities_.split.begin(
        *context.depth_model, blocks_, context.history, context.maxSymbol());
    intensities_.split.numbersOf(intensities_.symbols, intensities_.numbers);
  }
  else
    copyNumbers(intensities_.symbols, intensities_.numbers);
  if (!frame.keys.empty())
    sizes.occupancy = coder_.encode(context, blocks_, intensities_, payload);
  sizes.intensity = payload.size() - begin - sizes.occupancy;
  prepareLearning(frame, is_i_frame);
  if (is_i_frame && frame.keys.empty()) {
    coder_.prepareToForget();
    coder_.learn();
  }
  learnHistory();
  return sizes;
}

bool
Payload::decode(CodingWorkspace& /*work*/,
                const std::uint8_t* begin,
                const std::uint8_t* end,
                std::size_t voxel_count,
                bool is_i_frame,
                VoxelFrame& frame,
                PayloadSizes& sizes)
{
  sizes = PayloadSizes();
  blocks_.clear();
  if (voxel_count == 0) {
    if (begin != end)
      return false;
    intensities_.numbers.clear();
    intensities_.symbols.clear();
    if (is_i_frame)
      coder_.prepareToForget();
  }
  else if (!coder_.decode(contextOf(frame, is_i_frame),
                          begin,
                          end,
                          voxel_count,
                          blocks_,
                          intensities_,
                          sizes.occupancy))
    return false;
  sizes.intensity = static_cast<std::size_t>(end - begin) - sizes.occupancy;
  blocks_.voxelKeys(frame.keys);
  copyNumbers(intensities_.symbols, frame.intensities);
  prepareLearning(frame, is_i_frame);
  has_models_ = voxel_count != 0 || is_i_frame;
  return true;
}

void
Payload::prepareLearning(const VoxelFrame& frame, bool is_i_frame)
{
  symbol_bits_ = frame.intensity_scale.bits;
  is_i_frame_ = is_i_frame;
  has_depths_ = frame.depth_model && !frame.keys.empty();
  if (has_depths_)
    intensities_.split.observe(intensities_.numbers, intensities_.symbols, depths_);
  history_.makeRoom(blocks_, is_i_frame);
}

void
Payload::learn() noexcept
{
  if (has_models_)
    coder_.learn();
  learnHistory();
}

void
Payload::learnHistory() noexcept
{
  if (is_i_frame_)
    history_.clear(symbol_bits_, forgotten_below_);
  history_.update(
      blocks_, intensities_.numbers, has_depths_ ? &depths_ : nullptr, is_i_frame_);
}

void
Payload::giveBackMemory()
{
  coder_.giveBackMemory();
  history_.giveBackMemory();
  blocks_ = BlockList();
  intensities_ = CodedIntensities();
  depths_ = DepthObservations();
}

std::size_t
Payload::knownVoxels(CodingWorkspace& /*work*/, const VoxelFrame& frame)
{
  blocks_.assign(frame.keys);
  const std::vector<HistoryBlock>& known = history_.blocks();
  std::size_t voxels = 0;
  std::size_t old = 0;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    while (old < known.size() && known[old].key < blocks_.keys[i])
      ++old;
    if (old < known.size() && known[old].key == blocks_.keys[i])
      voxels += cellCount(blocks_.masks[i] & known[old].known);
  }
  return voxels;
}

} // namespace context
} // namespace io
} // namespace pcl_ext
