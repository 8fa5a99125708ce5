// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Depth images as files, the comparison of the paper's section 3.2.
 */
#pragma once

namespace pcl_ext {

namespace clouds {
class CloudSequence;
}

namespace measuring {
class Results;
}

namespace paper {

/** \brief Codes the depth image of every cloud of a depth camera raw, as PNG and as
 * JPEG.
 *
 * Quantities: bytes, encode_ms, decode_ms, error_mm (root mean square, where a return
 * came back as one) and wrong_percent (of the pixels with a return before or after:
 * those that are off by more than 10 cm, were lost or were made up).
 * \param[in,out] clouds organised, in the sensor's frame
 * \throws std::runtime_error if a coder fails, a cloud is not organised or a depth is
 * beyond 65 m
 */
void
measureDepthImages(clouds::CloudSequence& clouds, measuring::Results& results);

} // namespace paper
} // namespace pcl_ext
