#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/point_image.h>
#include <pcl_ext/status.h>

#include "bytes/byte_source.h"
#include "bytes/byte_writer.h"

namespace pcl_ext {
namespace io {

/** \brief Writes size and rays of an image, as an I-frame's header does
 * (doc/bitstream.md, "Frame header"). */
void
writeImageTable(const PointImage& image, ByteWriter& writer);

/** \brief Reads and checks what writeImageTable() wrote.
 * \param[out] image without points
 */
CompressionStatus
readImageTable(ByteSource& source, const DecoderLimits& limits, PointImage& image);

} // namespace io
} // namespace pcl_ext
