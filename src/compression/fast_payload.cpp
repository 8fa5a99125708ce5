#include "fast_payload.h"

#include "byte_source.h"
#include "byte_writer.h"
#include "memory_buffer.h"

#include <algorithm>

namespace pcl_ext {
namespace io {

PayloadSizes
FastPayload::encode(const VoxelFrame& frame,
                    bool is_i_frame,
                    std::vector<std::uint8_t>& payload)
{
  const std::size_t begin = payload.size();
  if (frame.keys.empty()) {
    if (is_i_frame)
      forget();
  }
  else if (frame.depth_model)
    encodeWithDepth(frame, is_i_frame, payload);
  else
    coder_.encode(is_i_frame,
                  frame.keys,
                  frame.intensities,
                  frame.intensity_scale.bits,
                  frame.grid.depth,
                  payload);
  const std::size_t rests =
      frame.depth_model && !frame.keys.empty() ? payload.size() - rests_begin_ : 0;
  return {payload.size() - begin - rests, rests};
}

void
FastPayload::encodeWithDepth(const VoxelFrame& frame,
                             bool is_i_frame,
                             std::vector<std::uint8_t>& payload)
{
  beginSplit(frame);
  split_.numbersOf(frame.intensities, numbers_);
  numbers_payload_.clear();
  coder_.encode(is_i_frame,
                frame.keys,
                numbers_,
                frame.intensity_scale.bits,
                frame.grid.depth,
                numbers_payload_);
  ByteWriter writer(payload);
  writer.varint(numbers_payload_.size());
  writer.raw(numbers_payload_.data(), numbers_payload_.size());
  rests_begin_ = payload.size();
  split_.predict(numbers_);
  collectClasses();
  row_.clear();
  for (std::size_t i = 0; i < numbers_.size(); ++i)
    if (split_.classes()[i] != DepthSplit::no_rest)
      row_.push_back(static_cast<std::uint16_t>(split_.rest(i, frame.intensities[i])));
  rests_.encode(is_i_frame, row_, row_classes_, payload);
}

bool
FastPayload::decode(const std::uint8_t* begin,
                    const std::uint8_t* end,
                    std::size_t voxel_count,
                    bool is_i_frame,
                    VoxelFrame& frame,
                    PayloadSizes& sizes)
{
  sizes = {static_cast<std::size_t>(end - begin), 0};
  if (voxel_count == 0) {
    frame.keys.clear();
    frame.intensities.clear();
    if (begin == end && is_i_frame)
      forget();
    return begin == end;
  }
  const std::uint8_t* rests = end;
  if (frame.depth_model) {
    const auto size = static_cast<std::size_t>(end - begin);
    MemoryBuffer buffer(begin, size);
    ByteSource source(buffer, size);
    const std::uint64_t numbers_size = source.varint();
    if (source.failure() != ByteSource::Failure::None ||
        numbers_size > size - source.consumed())
      return false;
    begin += source.consumed();
    rests = begin + numbers_size;
  }
  if (!coder_.decode(begin,
                     rests,
                     is_i_frame,
                     voxel_count,
                     frame.intensity_scale.bits,
                     frame.grid.depth,
                     frame.keys,
                     frame.intensities))
    return false;
  if (frame.depth_model && !decodeRests(rests, end, is_i_frame, frame)) {
    coder_.discard();
    return false;
  }
  coder_.commit();
  sizes.intensity = static_cast<std::size_t>(end - rests);
  sizes.occupancy -= sizes.intensity;
  return true;
}

bool
FastPayload::decodeRests(const std::uint8_t* begin,
                         const std::uint8_t* end,
                         bool is_i_frame,
                         VoxelFrame& frame)
{
  beginSplit(frame);
  split_.predict(frame.intensities);
  collectClasses();
  if (!rests_.decode(begin, end, is_i_frame, row_classes_, row_))
    return false;
  std::size_t next = 0;
  for (std::size_t i = 0; i < frame.size(); ++i)
    if (split_.classes()[i] != DepthSplit::no_rest &&
        !split_.symbol(i, row_[next++], frame.intensities[i])) {
      rests_.discard();
      return false;
    }
  return true;
}

void
FastPayload::beginSplit(const VoxelFrame& frame)
{
  blocks_.assign(frame.keys);
  split_.begin(
      *frame.depth_model, blocks_, no_history_, frame.intensity_scale.maxSymbol());
}

void
FastPayload::forget()
{
  coder_.reset();
  rests_.reset();
}

/** \brief The classes of the row: where in its symbol a prediction is, and the symbol's
 * size, of which most are large. */
void
FastPayload::collectClasses()
{
  row_classes_.clear();
  for (std::size_t i = 0; i < split_.classes().size(); ++i) {
    if (split_.classes()[i] == DepthSplit::no_rest)
      continue;
    const std::uint32_t size = std::clamp(split_.place(i) >> 4, 4u, 7u) - 4;
    row_classes_.push_back(
        static_cast<std::uint8_t>(size * 4 + (split_.place(i) >> 2 & 3)));
  }
}

} // namespace io
} // namespace pcl_ext
