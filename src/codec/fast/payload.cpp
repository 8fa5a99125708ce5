#include "codec/fast/payload.h"

#include "bytes/byte_source.h"
#include "bytes/byte_writer.h"
#include "bytes/memory_buffer.h"

#include <algorithm>

namespace pcl_ext {
namespace io {
namespace fast {

PayloadSizes
Payload::encode(CodingWorkspace& work,
                const VoxelFrame& frame,
                bool is_i_frame,
                std::vector<std::uint8_t>& payload)
{
  const std::size_t begin = payload.size();
  if (frame.keys.empty()) {
    if (is_i_frame)
      forget();
  }
  else if (frame.depth_model)
    encodeWithDepth(work.fast(), frame, is_i_frame, payload);
  else
    coder_.encode(work.fast(),
                  is_i_frame,
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
Payload::encodeWithDepth(Workspace& work,
                         const VoxelFrame& frame,
                         bool is_i_frame,
                         std::vector<std::uint8_t>& payload)
{
  beginSplit(frame);
  own_.split.numbersOf(frame.intensities, own_.numbers);
  own_.numbers_payload.clear();
  coder_.encode(work,
                is_i_frame,
                frame.keys,
                own_.numbers,
                frame.intensity_scale.bits,
                frame.grid.depth,
                own_.numbers_payload);
  ByteWriter writer(payload);
  writer.varint(own_.numbers_payload.size());
  writer.raw(own_.numbers_payload.data(), own_.numbers_payload.size());
  rests_begin_ = payload.size();
  own_.split.predict(own_.numbers);
  collectClasses();
  own_.row.clear();
  for (std::size_t i = 0; i < own_.numbers.size(); ++i)
    if (own_.split.classes()[i] != DepthSplit::no_rest)
      own_.row.push_back(
          static_cast<std::uint16_t>(own_.split.rest(i, frame.intensities[i])));
  rests_.encode(is_i_frame, own_.row, own_.row_classes, payload);
}

bool
Payload::decode(CodingWorkspace& work,
                const std::uint8_t* begin,
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
    change_ = is_i_frame ? Change::Emptied : Change::None;
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
  if (!coder_.decode(work.fast(),
                     begin,
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
  change_ = frame.depth_model ? Change::Everything : Change::VoxelsOnly;
  sizes.intensity = static_cast<std::size_t>(end - rests);
  sizes.occupancy -= sizes.intensity;
  return true;
}

bool
Payload::decodeRests(const std::uint8_t* begin,
                     const std::uint8_t* end,
                     bool is_i_frame,
                     VoxelFrame& frame)
{
  beginSplit(frame);
  own_.split.predict(frame.intensities);
  collectClasses();
  if (!rests_.decode(begin, end, is_i_frame, own_.row_classes, own_.row))
    return false;
  std::size_t next = 0;
  for (std::size_t i = 0; i < frame.size(); ++i)
    if (own_.split.classes()[i] != DepthSplit::no_rest &&
        !own_.split.symbol(i, own_.row[next++], frame.intensities[i]))
      return false;
  return true;
}

void
Payload::learn() noexcept
{
  if (change_ == Change::Emptied)
    forget();
  if (change_ == Change::VoxelsOnly || change_ == Change::Everything)
    coder_.learn();
  if (change_ == Change::Everything)
    rests_.learn();
}

void
Payload::discard() noexcept
{
  if (change_ == Change::VoxelsOnly || change_ == Change::Everything)
    coder_.discard();
}

void
Payload::giveBackMemory()
{
  coder_.giveBackMemory();
  rests_.giveBackMemory();
  own_ = DepthWork();
}

void
Payload::beginSplit(const VoxelFrame& frame)
{
  own_.blocks.assign(frame.keys);
  own_.split.begin(
      *frame.depth_model, own_.blocks, no_history_, frame.intensity_scale.maxSymbol());
}

void
Payload::forget() noexcept
{
  coder_.reset();
  rests_.reset();
}

/** \brief The classes of the row: where in its symbol a prediction is, and the symbol's
 * size, of which most are large. */
void
Payload::collectClasses()
{
  own_.row_classes.clear();
  for (std::size_t i = 0; i < own_.split.classes().size(); ++i) {
    if (own_.split.classes()[i] == DepthSplit::no_rest)
      continue;
    const std::uint32_t size = std::clamp(own_.split.place(i) >> 4, 4u, 7u) - 4;
    own_.row_classes.push_back(
        static_cast<std::uint8_t>(size * 4 + (own_.split.place(i) >> 2 & 3)));
  }
}

} // namespace fast
} // namespace io
} // namespace pcl_ext
