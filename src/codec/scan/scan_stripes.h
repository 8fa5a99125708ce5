// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "codec/scan/scan_frame.h"

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

/** \brief The points of some stripes of columns, a sample of neighbours from all parts of
 * a scan: about an eighth of the points.
 * \param[in] scan isConsistent(), no sequence
 */
ScanFrame
stripesOf(const ScanFrame& scan);

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io
