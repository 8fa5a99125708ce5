/** \file
 * \brief What depth images cost as PNG and JPEG, and what is left of the depth.
 */
#pragma once

#include "measuring/workload.h"
#include "result_file.h"

namespace pcl_ext {
namespace report {

/** \brief Codes the depth image of every cloud of a depth camera, whole and with what lies
 * outside of the crop box set to no return.
 *
 * Quantities: bytes, ratio (16 bytes for each cropped point against the bytes),
 * megabits_per_second, encode_ms, decode_ms, error_mm (root of the mean square, where a
 * return came back as one) and wrong_percent (of the pixels with a return before or after:
 * those that are off by more than 10 cm, were lost or were made up).
 * \throws std::runtime_error if a coder fails
 */
void
measureDepthImages(const measuring::InputStream& stream,
                   double frame_rate,
                   ResultFile& results);

} // namespace report
} // namespace pcl_ext
