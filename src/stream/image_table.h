// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/impl/point_image.h>
#include <pcl_ext/status.h>

#include "bytes/byte_source.h"
#include "bytes/byte_writer.h"

namespace pcl_ext {
namespace io {

/** \brief Writes size and rays of an image, as an I-frame's header does
 * (doc/bitstream.md, "Frame header"). */
void
writeImageTable(const PointImage& image, ByteWriter& writer);

/** \brief Writes where the rays of an image are, as an I-frame's header does, and that of
 * a P-frame with another pose. */
void
writeRayPose(const RayPose& pose, ByteWriter& writer);

/** \brief Reads what writeRayPose() wrote, unchecked. */
void
readRayPose(ByteSource& source, RayPose& pose);

/** \brief Reads and checks what writeImageTable() wrote.
 * \param[out] image without points
 */
CompressionStatus
readImageTable(ByteSource& source, PointImage& image);

} // namespace io
} // namespace pcl_ext
