#pragma once

#include <pcl_ext/compression/frame_description.h>

#include <cstddef>
#include <cstdint>
#include <optional>

namespace pcl_ext {
namespace link {

/** \brief What the followers of a stream need to know of a frame. */
struct FrameKind {
  bool is_i_frame = false;
  std::uint32_t number = 0; ///< in the encoder's stream
};

/** \brief Looks at bytes that are to be exactly one frame, without decoding it; nothing if
 * they are not. */
std::optional<FrameKind>
frameKindOf(const std::uint8_t* bytes, std::size_t count);

} // namespace link
} // namespace pcl_ext
