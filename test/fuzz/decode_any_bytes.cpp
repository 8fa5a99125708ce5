/** \file
 * Fuzz target: whatever the bytes, decoding ends, stays within its limits, and a frame is
 * either whole or not there.
 *
 * The first byte chooses how the others are read: as a stream, or as the parts of a
 * version 1 frame around which a correct header is put, because no fuzzer guesses a
 * checksum.
 */
#include <pcl_ext/compression/frame_decoder.h>

#include "compression/version1_header.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;

void
require(bool condition)
{
  if (!condition)
    std::abort();
}

DecoderLimits
limits()
{
  DecoderLimits limits;
  limits.max_frame_bytes = std::size_t{1} << 16;
  limits.max_voxels = std::size_t{1} << 14;
  return limits;
}

/** \brief Decodes until there is nothing more. */
void
decodeAll(const std::string& bytes)
{
  std::stringbuf buffer(bytes);
  FrameDecoder decoder(limits());
  VoxelFrame frame;
  // Every call takes at least a byte or says that there is none.
  for (std::size_t calls = 0; calls <= bytes.size() + 1; ++calls) {
    const CompressionStatus status = decoder.decode(buffer, frame);
    if (status.ok()) {
      require(isConsistent(frame) && frame.size() <= limits().max_voxels);
      continue;
    }
    require(frame.keys.empty() && frame.intensities.empty());
    require(!status.message().empty());
    if (status.code() == CompressionCode::EndOfStream)
      return;
  }
  std::abort();
}

/** \brief Takes numbers off the front of the bytes. */
class Parts {
public:
  Parts(const std::uint8_t* bytes, std::size_t size) : bytes_(bytes), size_(size) {}

  std::uint32_t
  number(std::uint32_t end)
  {
    std::uint32_t value = 0;
    for (int i = 0; i < 2 && size_ > 0; ++i, --size_)
      value = value << 8 | *bytes_++;
    return value % end;
  }

  std::vector<std::uint8_t>
  row(std::size_t most)
  {
    const std::size_t length = size_ < most ? size_ : most;
    std::vector<std::uint8_t> bytes(bytes_, bytes_ + length);
    bytes_ += length;
    size_ -= length;
    return bytes;
  }

  bool
  isAtEnd() const
  {
    return size_ == 0;
  }

private:
  const std::uint8_t* bytes_;
  std::size_t size_;
};

DepthModel
depthModel(Parts& parts)
{
  DepthModel model;
  model.exponent = static_cast<std::uint8_t>(1 + parts.number(2));
  // Every tenth model or so is none.
  model.full_symbol = parts.number(1 << 16) << parts.number(10);
  model.origin = (static_cast<std::int64_t>(parts.number(1 << 16)) - (1 << 15)) *
                 (std::int64_t{1} << parts.number(43));
  for (std::int32_t& step : model.step)
    step = static_cast<std::int32_t>(parts.number(1 << 16) << parts.number(17));
  return model;
}

/** \brief Frames, of which some are I-frames, with payloads of these bytes. */
std::string
framesAround(Parts parts)
{
  std::vector<std::uint8_t> bytes;
  std::uint32_t checksum = 0;
  bool stream_has_depth_model = false;
  Effort effort = Effort::Balanced;
  for (std::uint32_t number = 1; number <= 8 && !parts.isAtEnd(); ++number) {
    const std::uint32_t choice = parts.number(256);
    Version1Header header;
    header.is_i_frame = number == 1 || choice % 8 == 0;
    header.frame_number = number;
    if (header.is_i_frame || choice / 96 == 0)
      effort = static_cast<Effort>(choice / 8 % 3);
    header.effort = effort;
    if (header.is_i_frame) {
      header.grid.resolution = 0.04;
      header.grid.depth = 1 + parts.number(max_grid_depth);
      if (header.grid.depth == max_grid_depth)
        header.grid.first_index = {-(1 << 20), -(1 << 20), -(1 << 20)};
      const std::uint32_t scale = parts.number(32);
      header.intensity_scale.bits = 1 + scale % 16;
      if (scale >= 16 && header.intensity_scale.bits < 16)
        header.intensity_scale.companded_range = 65535;
      stream_has_depth_model = choice / 24 % 2 == 0;
    }
    header.has_depth_model =
        stream_has_depth_model && (header.is_i_frame || choice / 48 % 2 == 0);
    header.voxel_count = parts.number(1 << 15);
    std::vector<std::uint8_t> payload;
    if (header.has_depth_model)
      writeDepthModel(depthModel(parts), payload);
    const std::vector<std::uint8_t> voxels = parts.row(parts.number(1 << 12));
    payload.insert(payload.end(), voxels.begin(), voxels.end());
    header.payload_size = payload.size();
    checksum =
        writeVersion1Frame(header, payload, header.is_i_frame ? 0 : checksum, bytes);
  }
  return {bytes.begin(), bytes.end()};
}

} // namespace

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  if (size == 0)
    return 0;
  if (data[0] % 2 == 0)
    decodeAll({data + 1, data + size});
  else
    decodeAll(framesAround({data + 1, size - 1}));
  return 0;
}
