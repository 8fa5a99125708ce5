/** \file
 * \brief Depth images as files, the comparison of the paper's section 3.2.
 */
#pragma once

#include "measuring/result_file.h"
#include "measuring/workload.h"

namespace pcl_ext {
namespace report {

/** \brief Codes the depth image of every cloud of a depth camera raw, as PNG and as
 * JPEG; whole, and with the pixels outside of the crop box set to no return.
 *
 * Quantities: bytes, ratio (16 bytes for each cropped point against the bytes),
 * megabits_per_second, encode_ms, decode_ms, error_mm (root mean square, where a return
 * came back as one) and wrong_percent (of the pixels with a return before or after:
 * those that are off by more than 10 cm, were lost or were made up).
 * \param[in] stream organised clouds in the sensor's frame, with a crop box
 * \param[in] frame_rate Hz
 * \throws std::runtime_error if a coder fails, a cloud is not organised or a depth is
 * beyond 65 m
 */
void
measureDepthImages(const measuring::InputStream& stream,
                   double frame_rate,
                   measuring::ResultFile& results);

} // namespace report
} // namespace pcl_ext
