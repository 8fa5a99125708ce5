// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_status.h>

#include "inputs/viewpoints.h"

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief How the files of clouds are written. */
enum class CloudFormat { PcdBinary, PcdCompressed, PcdAscii, Ply };

/** \brief Names of folders for streams, without any character that is special in paths;
 * no two are the same. */
std::vector<std::string>
folderNames(const std::vector<std::string>& streams);

/** \brief Refuses a file, and a folder that has files, unless these may be replaced.
 * \throws UsageError
 */
void
refuseTakenFolder(const std::string& path, bool may_replace);

/** \brief A folder that gets a file for each cloud, in a folder for each stream if
 * there are several. The files are written beside it, or in a folder in it where it is
 * a mount of its own, and get their place when all are complete. Failures throw
 * std::exception. */
class CloudFolder {
public:
  /** \param[in] path of the folder
   * \param[in] may_replace clouds of earlier runs are replaced, unless there are some of
   * other streams or of others; else the folder must be new or empty
   * \param[in] folders of the streams in it; one stream alone has none
   */
  CloudFolder(const std::string& path,
              CloudFormat format,
              bool may_replace,
              std::vector<std::string> folders);

  /** \brief Removes the unfinished folder, unless a message has named it. */
  ~CloudFolder();
  CloudFolder(const CloudFolder&) = delete;
  CloudFolder&
  operator=(const CloudFolder&) = delete;

  /** \brief Writes a cloud as 000123.pcd, or .ply; if it has a time of a clock as
   * 000123_1700000000.123456789.pcd, as PCD and PLY have no field for it. A
   * failure names the unfinished folder, if it has clouds.
   * \param[in] stream index of its folder
   * \param[in] number of the frame
   * \param[in] cloud not empty: PCD has no empty clouds
   * \param[in] stamp of the cloud; before 2001 it is no time of a clock
   * \param[in] viewpoint of PCD files
   */
  void
  write(std::size_t stream,
        std::size_t number,
        const pcl::PCLPointCloud2& cloud,
        recording::Time stamp = {},
        const Viewpoint& viewpoint = {});

  /** \brief Moves all files to their place, where they replace those of their names, and
   * then removes the other clouds of an earlier run there. Clouds of others that would be
   * mixed with them are a failure. After an interruption the earlier ones stay. Where
   * that or a failure keeps files from their place, they stay in the unfinished folder,
   * which is named.
   * \return what became of what was there, for the summary; empty if nothing
   */
  std::string
  finish();

private:
  std::vector<std::filesystem::path>
  earlierClouds() const;

  std::vector<std::filesystem::path>
  leftOver(const std::vector<std::filesystem::path>& earlier) const;

  void
  checkForClouds(const std::vector<std::filesystem::path>& left_over);

  void
  moveClouds(const std::filesystem::path& from) const;

  /** \brief The unfinished folder, which from now on is not removed. */
  std::filesystem::path
  keepUnfinished();

  std::filesystem::path path_;
  std::filesystem::path unfinished_;
  CloudFormat format_;
  bool may_replace_;
  std::vector<std::string> folders_;
  bool has_written_ = false;
};

} // namespace pcl_ext::tools
