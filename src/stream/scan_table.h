// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/status.h>

#include "bytes/byte_source.h"
#include "bytes/byte_writer.h"
#include "codec/scan/scan_frame.h"

#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Writes the layout of a scan, as an I-frame's header does (doc/bitstream.md,
 * "Frame header"). */
void
writeScanTable(const scan::ScanLayout& layout, ByteWriter& writer);

/** \brief Reads and checks what writeScanTable() wrote. */
CompressionStatus
readScanTable(ByteSource& source, scan::ScanLayout& layout);

/** \brief What a P-frame's header has of the layout, if it has changed. */
struct ScanPlacement {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  scan::RayPose pose;
  scan::RayPose motion; ///< of a spinning sensor

  bool
  operator!=(const ScanPlacement& other) const
  {
    return width != other.width || height != other.height || pose != other.pose ||
           motion != other.motion;
  }
};

inline ScanPlacement
placementOf(const scan::ScanLayout& layout)
{
  return {layout.width, layout.height, layout.rays.pose, layout.rays.motion};
}

/** \brief Sets the placement of a layout, unchecked. */
inline void
setPlacement(const ScanPlacement& placement, scan::ScanLayout& layout)
{
  layout.width = placement.width;
  layout.height = placement.height;
  layout.rays.pose = placement.pose;
  layout.rays.motion = placement.motion;
}

/** \brief Writes the placement of a P-frame. */
void
writeScanPlacement(const ScanPlacement& placement, ByteWriter& writer);

/** \brief Reads what writeScanPlacement() wrote, unchecked. */
void
readScanPlacement(ByteSource& source, ScanPlacement& placement);

} // namespace pcl_ext::PCL_EXT_ABI::io
