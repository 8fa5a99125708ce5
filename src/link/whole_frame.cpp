#include "link/whole_frame.h"

#include <pcl_ext/compression/frame_decoder.h>

#include <limits>

namespace pcl_ext {
namespace link {

std::optional<WholeFrame>
wholeFrameOf(const std::uint8_t* bytes, std::size_t size)
{
  // The limits are those of whoever decodes the frame.
  io::DecoderLimits limits;
  limits.max_frame_bytes = std::numeric_limits<std::uint32_t>::max();
  limits.max_voxels = std::numeric_limits<std::uint32_t>::max();
  limits.max_points = std::numeric_limits<std::uint32_t>::max();
  const io::FrameSize known = io::frameSize(bytes, size, limits);
  if (!known.status.ok() || known.known != size)
    return std::nullopt;
  WholeFrame frame{io::describeFrame(bytes, size, limits), bytes, size};
  if (!frame.description.status.ok())
    return std::nullopt;
  return frame;
}

} // namespace link
} // namespace pcl_ext
