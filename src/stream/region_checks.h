#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/status.h>

namespace pcl_ext {
namespace io {

/** \brief Checks the regions of an encoder's settings, whose resolution is valid. */
CompressionStatus
checkRegions(const EncoderSettings& settings);

} // namespace io
} // namespace pcl_ext
