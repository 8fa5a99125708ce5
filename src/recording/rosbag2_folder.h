// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/recording/recording_status.h>

#include "recording/mcap_content.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief True if a file has the name of one of a bag: .mcap or .db3, with .zstd after
 * it where rosbag2 compressed it. Those that begin with ._ are macOS's. */
PCL_EXT_RECORDING_EXPORT bool
hasNameOfBagFile(const std::string& path);

/** \brief The name of such a file without folder and extensions. */
PCL_EXT_RECORDING_EXPORT std::string
nameOfBagFile(const std::string& path);

/** \brief True if a path is a folder with the metadata of a rosbag2 bag, or without it
 * if its files are named as those of one bag. */
PCL_EXT_RECORDING_EXPORT bool
isRosbag2Folder(const std::string& path);

/** \brief True if the files of bags in a folder have one name but for their numbers,
 * which are 0, 1 and so on, as the parts of one bag. They may be bags of their own. */
PCL_EXT_RECORDING_EXPORT bool
mayBeParts(const std::string& folder);

/** \brief The files of a rosbag2 folder in the order of their numbers.
 * \param[in] folder the folder
 * \param[out] files paths
 * \return NotARecording if there are none
 */
RecordingStatus
filesOfRosbag2Folder(const std::string& folder, std::vector<std::string>& files);

/** \brief What is lost of a bag whose metadata.yaml names files that are not in its
 * folder.
 * \param[in] folder the folder
 * \return empty if all are there
 */
std::vector<RecordingDamage>
findMissingFiles(const std::string& folder);

/** \brief What is lost of a bag that has fewer messages than its metadata.yaml counts.
 * \param[in] folder the folder
 * \param[in] found number of its messages
 * \return nothing if it has as many, or if there is no number
 */
std::optional<RecordingDamage>
findMissingMessages(const std::string& folder, std::size_t found);

/** \brief Name under which channels and metadata.yaml have the QoS of publishers. */
constexpr char qos_metadata[] = "offered_qos_profiles";

/** \brief Gives channels the QoS that stands only in the folder's metadata.yaml.
 * \param[in] folder the folder
 * \param[in,out] channels of all of its files
 */
void
addQosOfMetadata(const std::string& folder, std::vector<McapChannel>& channels);

/** \brief What the metadata of a bag says of a topic. */
struct Rosbag2Topic {
  const McapChannel* channel = nullptr;
  std::uint64_t messages = 0;
};

/** \brief Writes metadata.yaml of a bag of one file, as rosbag2 does: version 5 of it,
 * or version 9 if QoS has the names of policies that version 5 has not.
 * \param[in] folder the folder
 * \param[in] file name of the MCAP file in it
 * \param[in] topics channels with their numbers of messages
 * \param[in] first_time,last_time of the messages
 */
RecordingStatus
writeRosbag2Metadata(const std::string& folder,
                     const std::string& file,
                     const std::vector<Rosbag2Topic>& topics,
                     Time first_time,
                     Time last_time);

} // namespace pcl_ext::PCL_EXT_ABI::recording
