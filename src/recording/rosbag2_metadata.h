// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <map>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief Reads which QoS the publishers of each topic offered, from the text of a
 * bag's metadata.yaml.
 *
 * It reads the styles of YAML in which rosbag2 and other writers of bags put it there:
 * a text with or without quotes, a block of text, or since version 9 a list.
 * \return YAML by topic, as channels of MCAP files have it; topics without are left out
 */
std::map<std::string, std::string>
readOfferedQos(const std::string& metadata);

/** \brief Reads the names of the bag's files, as metadata.yaml lists them, without
 * folders. */
std::vector<std::string>
readFileNames(const std::string& metadata);

/** \brief A value of the bag itself, such as its "storage_identifier". */
std::string
readValue(const std::string& metadata, const std::string& key);

/** \brief True if policies have names, such as "reliable", as since version 9 of the
 * metadata, and not numbers. */
bool
hasNamedPolicies(const std::string& qos);

/** \brief Gives policies that are numbers, those of rmw, their names. */
std::string
withNamedPolicies(const std::string& qos);

} // namespace pcl_ext::PCL_EXT_ABI::recording
