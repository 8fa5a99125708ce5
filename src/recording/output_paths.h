// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/recording/recording_status.h>

#include <string>

// What is exported is for the program pcl_ext and the Python package.

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief What the name of an output asks for. */
enum class OutputKind {
  Frames, ///< .pcxi, or - for the standard output: one stream
  Mcap,   ///< .mcap
  Folder  ///< no extension, or a slash at the end
};

/** \brief The kind of an output by its name.
 * \return InvalidArgument for other extensions, and for names that no file has
 */
PCL_EXT_RECORDING_EXPORT RecordingStatus
kindOfOutput(const std::string& path, OutputKind& kind);

/** \brief Refuses devices and pipes, which cannot be given a name when all is
 * written. */
PCL_EXT_RECORDING_EXPORT RecordingStatus
refuseDevice(const std::string& path);

/** \brief Refuses an output that cannot become one: a device, a name of no kind, a
 * folder that exists, a file where a folder is to be.
 * \param[out] kind of the output
 */
PCL_EXT_RECORDING_EXPORT RecordingStatus
checkOutput(const std::string& path, OutputKind& kind);

/** \brief Refuses a file that exists.
 * \param[in] path of the output; - and folders are for checkOutput()
 * \param[in] remedy what replaces it: "--overwrite"
 */
PCL_EXT_RECORDING_EXPORT RecordingStatus
refuseTakenFile(const std::string& path, const std::string& remedy);

/** \brief Where an MCAP file or a rosbag2 folder is until it is complete, and
 * afterwards. */
struct OutputPaths {
  /** \param[in] path as McapWriter::open() takes it */
  explicit OutputPaths(const std::string& path);

  bool is_folder = false;
  std::string final;      // empty: the standard output
  std::string unfinished; // file or folder
  std::string file;       // that is written
  std::string file_name;  // in the folder
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
