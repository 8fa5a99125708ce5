// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/PCLPointCloud2.h>

#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief Which values of separate channels are full, in all clouds of a stream; black
 * is 0. A cloud with a colour other than black sets what is not set. */
struct ColourScale {
  std::optional<double> colour; ///< 1, 255 or 65535
  std::optional<double> alpha;  ///< likewise
};

/** \brief Packs separate channels of a colour (red, green, blue, r, g, b, diffuse_red
 * ..., in any case, with alpha or a) into `rgb`, or `rgba`, at the place of the first.
 * Whole numbers up to 255 are taken as they are, and up to 65535 as 16 bits; others from
 * 0 to 1 as shares. Other values are no colours. Where there is a packed colour, channels
 * stay.
 * \param[in,out] cloud its rows without gaps
 * \param[in] is_ply so that channels of 8 bits are the usual way of having colours
 * \param[in,out] scale of the stream's colours, to which larger values are clamped
 * \param[in,out] remarks is appended to
 * \return what is to be said of values beyond the scale; empty: there are none
 */
std::string
packColours(pcl::PCLPointCloud2& cloud,
            bool is_ply,
            ColourScale& scale,
            std::vector<std::string>& remarks);

} // namespace clouds
} // namespace pcl_ext
