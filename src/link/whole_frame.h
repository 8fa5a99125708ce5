// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_description.h>

#include <cstddef>
#include <cstdint>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::link {

/** \brief Bytes that are exactly one frame, and what its header tells. */
struct WholeFrame {
  io::FrameDescription description;
  const std::uint8_t* bytes = nullptr; ///< not owned
  std::size_t size = 0;
};

/** \brief Looks at bytes that are to be exactly one frame, without decoding it; nothing
 * if they are not. */
std::optional<WholeFrame>
wholeFrameOf(const std::uint8_t* bytes, std::size_t size);

} // namespace pcl_ext::PCL_EXT_ABI::link
