/** \file
 * Fuzz target: whatever the bytes, decoding ends, stays within its limits, and a frame is
 * either whole or not there.
 *
 * The bytes are a stream as it is. No fuzzer guesses a checksum, so what comes behind one
 * is the target `frames`.
 */
#include "seekable_buffer.h"
#include "small_streams.h"

#include <cstddef>
#include <cstdint>

using namespace pcl_ext::fuzz;
using namespace pcl_ext::io;

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  SeekableBuffer buffer(data, size);
  FrameDecoder decoder(smallLimits());
  VoxelFrame frame;
  // Every call takes at least a byte or says that there is none.
  for (std::size_t calls = 0; calls <= size + 1; ++calls) {
    const CompressionStatus status = decoder.decode(buffer, frame);
    if (status.ok()) {
      require(isConsistent(frame) && frame.size() <= smallLimits().max_voxels);
      continue;
    }
    require(frame.keys.empty() && frame.intensities.empty());
    require(!status.message().empty());
    if (status.code() == CompressionCode::EndOfStream)
      return 0;
  }
  std::abort();
}
