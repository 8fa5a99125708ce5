// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "inputs/cloud_input.h"

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief The first clouds of a stream, held in memory to be encoded more than once. */
struct HeldClouds {
  std::string name;      ///< of the stream
  bool is_topic = false; ///< of a bag
  std::vector<pcl::PCLPointCloud2> clouds;
  double period = 0.0; ///< seconds from one to the next, by their stamps; 0: unknown
  bool has_assumed_period = false;   ///< nothing tells the times of the clouds
  std::vector<std::string> failures; ///< why clouds could not be read
};

/** \brief Reads the first clouds of each stream of an input, to its end, for 30 s, until
 * they have 256 MiB, which the last one may pass, or until the program is interrupted.
 * \param[in] clouds the most of each stream
 * \return the streams in the order of the input, those without clouds as well
 */
std::vector<HeldClouds>
holdClouds(CloudInput& input, std::size_t clouds);

} // namespace pcl_ext::tools
