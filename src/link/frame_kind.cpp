#include "link/frame_kind.h"

#include <pcl_ext/compression/frame_decoder.h>

#include <limits>

namespace pcl_ext {
namespace link {

std::optional<FrameKind>
frameKindOf(const std::uint8_t* bytes, std::size_t count)
{
  // The limits are those of whoever decodes the frame.
  io::DecoderLimits limits;
  limits.max_frame_bytes = std::numeric_limits<std::uint32_t>::max();
  limits.max_voxels = std::numeric_limits<std::uint32_t>::max();
  limits.max_points = std::numeric_limits<std::uint32_t>::max();
  const io::FrameSize size = io::frameSize(bytes, count, limits);
  if (!size.status.ok() || size.known != count)
    return std::nullopt;
  const io::FrameDescription frame = io::describeFrame(bytes, count, limits);
  if (!frame.status.ok())
    return std::nullopt;
  return FrameKind{frame.is_i_frame, frame.frame_number};
}

} // namespace link
} // namespace pcl_ext
