// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief True for a bag: a file or a folder of rosbag2, an MCAP file, a bag of ROS 1;
 * also for a folder that has no metadata.yaml and files that are numbered as parts of a
 * bag. \throws std::runtime_error if it cannot be read
 */
bool
isBag(const std::string& path);

/** \brief The bag in a folder that is none itself and has one; else empty. */
std::string
onlyBagIn(const std::string& path);

/** \brief The bags that inputs stand for, where these are several bags, or folders of
 * bags: each is encoded by itself then. Files count as bags by their names, too, so that
 * one that is damaged does not keep the others from being encoded.
 * \param[in] inputs as the user gave them
 * \param[in] takes_one one bag that is named counts as several
 * \param[in] is_for_file the output takes one bag: then one in a folder is the input
 * \return none if the inputs are one bag, or clouds
 * \throws std::exception with a message for the user if they are a mixture
 */
std::vector<std::string>
severalBags(const std::vector<std::string>& inputs, bool takes_one, bool is_for_file);

/** \brief A folder of bags, with the names of what in it is no bag. */
struct FolderOfBags {
  std::string path;
  std::vector<std::string> other_folders;
  std::vector<std::string> other_files; ///< but for hidden ones
  /** \brief One of the folders that may be a bag without metadata.yaml, or empty. */
  std::string unfinished;
};

/** \brief The folders of bags among inputs that have something else, too: it is left
 * out. */
std::vector<FolderOfBags>
foldersWithOthers(const std::vector<std::string>& inputs);

/** \brief The paths that a pattern stands for, in their order; the path itself if it is
 * none.
 * \throws std::runtime_error if there are none
 */
std::vector<std::string>
pathsOf(const std::string& pattern);

} // namespace pcl_ext::tools
