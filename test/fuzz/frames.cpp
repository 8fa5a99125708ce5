/** \file
 * Fuzz target: a row of frames, made by an encoder and then changed behind its back, with
 * checksums that are right again most of the time. Decoding never crashes or throws; a
 * frame that is Ok is consistent, within its grid and within the limits; one that is not
 * is empty and comes with a reason; and whatever came, the next whole I-frame and the
 * P-frame behind it decode to exactly their voxels.
 *
 * The input is a stream. The mutator takes it apart into frames, changes fields of headers,
 * depth models, payloads, symbols of the published layout and the order of the frames, and
 * computes the chain of checksums anew.
 */
#include "codec/published/entropy_coder.h"
#include "frame_row.h"
#include "seekable_buffer.h"
#include "small_streams.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <utility>

// Of the fuzzer: changes bytes as it does without a mutator of ours.
extern "C" std::size_t
LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

using namespace pcl_ext::fuzz;
using namespace pcl_ext::io;
using pcl_ext::io::test::Parts;

// ---------------------------------------------------------------- the promise

/** \brief An I-frame and a P-frame of another sender, for each effort and of the published
 * layout. */
const std::array<SentStream, 4>&
freshStreams()
{
  static const auto streams = [] {
    constexpr StreamKind kinds[] = {
        {StreamFormat::Version1, Effort::Fast, false},
        {StreamFormat::Version1, Effort::Balanced, false},
        {StreamFormat::Version1, Effort::Small, false},
        {StreamFormat::Published, Effort::Balanced, false},
    };
    auto made = std::make_unique<std::array<SentStream, 4>>();
    for (std::size_t i = 0; i < made->size(); ++i)
      sendAll(kinds[i], sensorFrames(kinds[i], 77, 2, 0.0625), 100, 1, (*made)[i]);
    return made;
  }();
  return *streams;
}

/** \brief What was decoded last; a new decoder stands before frame 1. */
struct LastFrame {
  bool is_published = false;
  std::uint32_t number = 0;
  std::uint8_t flags = 0; // version 1
};

void
requireFreshFrames(FrameDecoder& decoder, const LastFrame& last)
{
  const SentStream& stream =
      freshStreams()[last.is_published ? 3 : std::size_t{last.flags} >> 4];
  std::uint32_t checksum = 0;
  for (std::uint32_t i = 0; i < stream.frames.size(); ++i) {
    const SentFrame& sent = stream.frames[i];
    Bytes bytes = sent.bytes;
    // Behind all that was decoded.
    const std::uint32_t number = last.number + 1 + i;
    if (last.is_published)
      for (std::size_t byte = 0; byte < 4; ++byte)
        bytes[published::magic_size + byte] =
            static_cast<std::uint8_t>(number >> 8 * byte);
    else
      checksum = renumber(number, sent.is_i_frame ? 0 : checksum, bytes);
    VoxelFrame frame;
    require(decoder.decode(bytes.data(), bytes.size(), frame).ok());
    require(isSame(sent, frame, decoder.stamp()));
  }
}

/** \brief What isConsistent says, and what the limits and the grid say, once more. */
void
requireGoodFrame(const VoxelFrame& frame)
{
  require(isConsistent(frame));
  require(frame.size() <= smallLimits().max_voxels);
  require(frame.keys.size() == frame.intensities.size());
  for (std::size_t i = 0; i < frame.size(); ++i) {
    require(i == 0 || frame.keys[i - 1] < frame.keys[i]);
    require(frame.keys[i] >> (3 * frame.grid.depth) == 0);
    require(frame.intensities[i] <= frame.intensity_scale.maxSymbol());
  }
}

// ---------------------------------------------------------------- the mutator

/** \brief Random numbers that cost nothing to begin with (splitmix64). */
class Random {
public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t
  next()
  {
    state_ += 0x9e3779b97f4a7c15;
    std::uint64_t mixed = state_;
    mixed = (mixed ^ mixed >> 30) * 0xbf58476d1ce4e5b9;
    mixed = (mixed ^ mixed >> 27) * 0x94d049bb133111eb;
    return mixed ^ mixed >> 31;
  }

  std::size_t
  below(std::size_t end)
  {
    return static_cast<std::size_t>(next() % end);
  }

  bool
  oneOf(std::size_t count)
  {
    return below(count) == 0;
  }

private:
  std::uint64_t state_;
};

/** \brief Any number: small ones, such next to a power of two, and all others. */
std::uint64_t
anyNumber(Random& random)
{
  switch (random.below(4)) {
  case 0:
    return random.below(4);
  case 1:
    return (std::uint64_t{1} << random.below(64)) + random.below(3) - 1;
  case 2:
    return random.below(2000);
  default:
    return random.next();
  }
}

/** \brief A number near another one, or any. */
template <typename NumberT>
void
change(NumberT& number, Random& random)
{
  number = static_cast<NumberT>(random.oneOf(2) ? static_cast<std::uint64_t>(number) +
                                                      random.below(5) - 2
                                                : anyNumber(random));
}

/** \brief A float of any bits. */
template <typename NumberT, typename BitsT>
void
changeBits(NumberT& number, Random& random)
{
  static_assert(sizeof(NumberT) == sizeof(BitsT), "bits of the number");
  BitsT bits;
  std::memcpy(&bits, &number, sizeof(bits));
  if (random.oneOf(4))
    bits = static_cast<BitsT>(anyNumber(random));
  else
    bits = static_cast<BitsT>(bits ^ BitsT{1} << random.below(8 * sizeof(bits)));
  std::memcpy(&number, &bits, sizeof(bits));
}

void
changeBytes(Bytes& bytes, std::size_t most)
{
  const std::size_t size = bytes.size();
  bytes.resize(std::max(size + 32, std::size_t{64}));
  bytes.resize(LLVMFuzzerMutate(bytes.data(), size, std::min(bytes.size(), most)));
}

void
changeDepthModel(Bytes& payload, Random& random)
{
  DepthModel model;
  if (payload.size() < depth_model_size)
    return;
  readDepthModel(payload.data(), model);
  switch (random.below(4)) {
  case 0:
    change(model.exponent, random);
    break;
  case 1:
    change(model.full_symbol, random);
    break;
  case 2:
    change(model.origin, random);
    break;
  default:
    change(model.step[random.below(3)], random);
  }
  Bytes written;
  writeDepthModel(model, written);
  std::copy(written.begin(), written.end(), payload.begin());
}

void
changeScale(IntensityScale& scale, Random& random)
{
  switch (random.below(4)) {
  case 0:
    changeBits<float, std::uint32_t>(scale.offset, random);
    break;
  case 1:
    changeBits<float, std::uint32_t>(scale.step, random);
    break;
  case 2:
    scale.bits = static_cast<unsigned int>(random.below(18));
    break;
  default:
    scale.companded_range = static_cast<std::uint32_t>(random.below(1 << 16));
  }
}

void
changeHeader(Parts& parts, Random& random)
{
  Version1Header& header = parts.header;
  switch (random.below(12)) {
  case 0:
    header.is_i_frame = !header.is_i_frame;
    break;
  case 1:
    header.has_depth_model = !header.has_depth_model;
    if (header.has_depth_model)
      parts.payload.insert(parts.payload.begin(), depth_model_size, 1);
    break;
  case 2:
    header.effort = static_cast<Effort>(random.below(3));
    break;
  case 3:
    change(header.frame_number, random);
    break;
  case 4:
    changeBits<double, std::uint64_t>(header.grid.resolution, random);
    break;
  case 5:
    change(header.grid.first_index[random.below(3)], random);
    break;
  case 6:
    header.grid.depth = static_cast<unsigned int>(random.below(24));
    break;
  case 7:
    changeScale(header.intensity_scale, random);
    break;
  case 8:
    if (random.oneOf(3))
      header.stamp.reset();
    else
      header.stamp = static_cast<std::int64_t>(anyNumber(random));
    break;
  case 9:
    header.has_frame_id = !header.has_frame_id;
    header.frame_id.assign(random.below(random.oneOf(8) ? 1100 : 30), 'f');
    break;
  default:
    change(header.voxel_count, random);
  }
}

void
changeVersion1(RowFrame& frame, Random& random)
{
  std::optional<Parts> parts = frame.parts();
  if (!parts || random.oneOf(16)) {
    changeBytes(frame.bytes, smallLimits().max_frame_bytes);
    return;
  }
  const std::size_t kind = random.below(8);
  if (kind < 3)
    changeHeader(*parts, random);
  else if (kind == 3 && parts->header.has_depth_model)
    changeDepthModel(parts->payload, random);
  else
    changeBytes(parts->payload, smallLimits().max_frame_bytes);
  // Sizes lie now and then.
  if (random.oneOf(16))
    change(parts->header.payload_size, random);
  else
    parts->header.payload_size = parts->payload.size();
  frame.bytes = putTogether(*parts);
}

/** \brief Changes symbols of the published layout; its redundancy, which stands in for a
 * checksum, is right again. */
void
changePublished(RowFrame& frame, Random& random)
{
  constexpr std::size_t header_size = published::magic_size + 4 + 1;
  constexpr std::size_t grid_size = 8 + 7 * 8;
  const std::size_t begin =
      frame.bytes.size() > header_size && frame.bytes[header_size - 1] != 0
          ? header_size + grid_size
          : header_size;
  Bytes rows[2]; // occupancy bytes and intensities
  bool is_whole = frame.bytes.size() >= begin;
  if (is_whole) {
    MemoryBuffer buffer(frame.bytes.data() + begin, frame.bytes.size() - begin);
    ByteSource source(buffer, frame.bytes.size());
    for (Bytes& row : rows) {
      const std::uint64_t count = source.u64();
      is_whole = is_whole && count <= smallLimits().max_frame_bytes &&
                 published::decodeStaticRange(source, static_cast<std::size_t>(count), row);
    }
  }
  if (!is_whole || random.oneOf(8)) {
    changeBytes(frame.bytes, smallLimits().max_frame_bytes);
    return;
  }
  std::uint64_t counts[2];
  Bytes& changed = rows[random.below(2)];
  changeBytes(changed, smallLimits().max_voxels);
  for (std::size_t i = 0; i < 2; ++i)
    counts[i] = rows[i].size();
  // Mostly as many intensities as there were or as there are said to be.
  if (random.oneOf(16))
    change(counts[random.below(2)], random);
  frame.bytes.resize(begin);
  if (begin > header_size && !random.oneOf(8))
    for (std::size_t i = 0; i < 8; ++i)
      frame.bytes[header_size + i] = static_cast<std::uint8_t>(counts[1] >> 8 * i);
  ByteWriter writer(frame.bytes);
  for (std::size_t i = 0; i < 2; ++i) {
    writer.u64(counts[i]);
    published::encodeStaticRange(rows[i], frame.bytes);
  }
}

void
changeFrame(RowFrame& frame, Random& random)
{
  if (frame.isVersion1())
    changeVersion1(frame, random);
  else if (frame.isPublished())
    changePublished(frame, random);
  else
    changeBytes(frame.bytes, smallLimits().max_frame_bytes);
}

/** \brief An I-frame of any grid and scale, with any bytes as payload. */
Bytes
forgedFrame(Random& random)
{
  Parts parts;
  Version1Header& header = parts.header;
  header.effort = static_cast<Effort>(random.below(3));
  header.frame_number = static_cast<std::uint32_t>(random.below(5));
  header.grid.resolution = 0.04;
  header.grid.depth = static_cast<unsigned int>(1 + random.below(max_grid_depth));
  if (header.grid.depth == max_grid_depth)
    header.grid.first_index.fill(-(1 << 20));
  header.intensity_scale.bits = static_cast<unsigned int>(1 + random.below(16));
  if (random.oneOf(4))
    header.intensity_scale.companded_range = 65535;
  header.voxel_count = random.below(random.oneOf(4) ? 1025 : 20);
  parts.payload.resize(random.below(random.oneOf(4) ? 400 : 40));
  for (std::uint8_t& byte : parts.payload)
    byte = static_cast<std::uint8_t>(random.next());
  header.has_depth_model = random.oneOf(4);
  if (header.has_depth_model) {
    Bytes model;
    writeDepthModel(
        test::roomDepthModel(header.grid.depth, header.intensity_scale.bits), model);
    parts.payload.insert(parts.payload.begin(), model.begin(), model.end());
  }
  return test::putTogetherSized(parts);
}

/** \brief One change of a row that has frames. */
void
changeRow(FrameRow& row, Random& random)
{
  std::vector<RowFrame>& frames = row.frames;
  const std::size_t place = random.below(frames.size());
  const auto at = [&frames](std::size_t index) {
    return frames.begin() + static_cast<std::ptrdiff_t>(index);
  };
  switch (random.below(16)) {
  case 0: // lost
    frames.erase(at(place));
    return;
  case 1: { // repeated, early or late
    const RowFrame copy = frames[place];
    frames.insert(at(random.below(frames.size() + 1)), copy);
    return;
  }
  case 2: // swapped
    std::swap(frames[place], frames[random.below(frames.size())]);
    return;
  case 3: { // of another stream
    const SentStream& stream = freshStreams()[random.below(freshStreams().size())];
    const Bytes& bytes = stream.frames[random.below(stream.frames.size())].bytes;
    frames.insert(at(place), row.newFrame(bytes));
    return;
  }
  case 4:
    frames.insert(at(place), row.newFrame(forgedFrame(random)));
    return;
  case 5: // what depended on it depends on the frame before it
    if (place > 0)
      for (std::size_t i = place + 1; i < frames.size(); ++i)
        if (frames[i].reference == frames[place].id)
          frames[i].reference = frames[place - 1].id;
    changeFrame(frames[place], random);
    return;
  case 6: // two in one
    if (place + 1 < frames.size()) {
      const Bytes& next = frames[place + 1].bytes;
      Bytes& bytes = frames[place].bytes;
      const std::size_t kept = random.below(bytes.size() + 1);
      bytes.resize(kept);
      bytes.insert(bytes.end(),
                   next.begin() +
                       static_cast<std::ptrdiff_t>(random.below(next.size() + 1)),
                   next.end());
    }
    return;
  default:
    changeFrame(frames[place], random);
  }
}

} // namespace

extern "C" std::size_t
LLVMFuzzerCustomMutator(std::uint8_t* data,
                        std::size_t size,
                        std::size_t max_size,
                        unsigned int seed)
{
  Random random(seed);
  if (random.oneOf(32))
    return LLVMFuzzerMutate(data, size, max_size);
  FrameRow row(data, size);
  if (row.frames.empty())
    row.frames.push_back(row.newFrame(forgedFrame(random)));
  for (std::size_t changes = 1 + random.below(3); changes > 0; --changes)
    if (!row.frames.empty())
      changeRow(row, random);
  if (!random.oneOf(16))
    row.putRight(!random.oneOf(4));
  return row.write(data, max_size);
}

extern "C" std::size_t
LLVMFuzzerCustomCrossOver(const std::uint8_t* data1,
                          std::size_t size1,
                          const std::uint8_t* data2,
                          std::size_t size2,
                          std::uint8_t* out,
                          std::size_t max_size,
                          unsigned int seed)
{
  Random random(seed);
  FrameRow row(data1, size1);
  const FrameRow other(data2, size2);
  const std::size_t kept = random.below(row.frames.size() + 1);
  const std::size_t begin = random.below(other.frames.size() + 1);
  std::vector<RowFrame> tail(row.frames.begin() + static_cast<std::ptrdiff_t>(kept),
                             row.frames.end());
  row.frames.resize(kept);
  for (std::size_t i = begin; i < other.frames.size(); ++i) {
    // Either in front of what was there, frame by frame, or instead of it.
    row.frames.push_back(row.newFrame(other.frames[i].bytes));
    if (random.oneOf(2) && !tail.empty()) {
      row.frames.push_back(tail.front());
      tail.erase(tail.begin());
    }
  }
  if (!random.oneOf(8))
    row.putRight(random.oneOf(2));
  return row.write(out, max_size);
}

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  SeekableBuffer buffer(data, size);
  FrameDecoder decoder(smallLimits());
  VoxelFrame frame;
  LastFrame last;
  // Every call takes at least a byte or says that there is none.
  for (std::size_t calls = 0;; ++calls) {
    require(calls <= size + 1);
    const CompressionStatus status = decoder.decode(buffer, frame);
    if (status.ok()) {
      requireGoodFrame(frame);
      const std::uint8_t* const begin =
          data + buffer.position() - decoder.statistics().bytes;
      last.is_published = begin[0] == '<';
      last.number = decoder.statistics().frame_number;
      if (!last.is_published)
        last.flags = begin[test::flags_offset];
      continue;
    }
    require(frame.keys.empty() && frame.intensities.empty());
    require(!status.message().empty());
    if (status.code() == CompressionCode::EndOfStream)
      break;
  }
  requireFreshFrames(decoder, last);
  return 0;
}
