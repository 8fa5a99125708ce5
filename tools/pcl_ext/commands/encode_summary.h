#pragma once

#include "options/encoding_options.h"
#include "streams/stream_encoder.h"

#include <string>

namespace pcl_ext {
namespace tools {

/** \brief What became of the points of all streams, for the summary of encode.
 * \param[in] sums over all streams
 * \param[in] bytes_a_second of the frames; 0: unknown
 */
std::string
describeEncoded(const EncodedSums& sums,
                const EncodingOptions& options,
                double bytes_a_second);

} // namespace tools
} // namespace pcl_ext
