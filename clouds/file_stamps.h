// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Times in the names of files.
 */
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief The time that the name of a file ends with, before its extension:
 *
 * - seconds with a point: of a clock (at least 10 digits before the point, 1 to 9 after
 *   it), or any with 6 or 9 digits after it, as ROS and TUM's data sets write them;
 * - 10, 13, 16 or 19 digits, the first of which is not 0: seconds, milliseconds,
 *   microseconds or nanoseconds since 1970;
 * - date and time of day in UTC, `YYYYMMDDThhmmss` of 1970 to 2261, with or without a
 *   point and 1 to 9 digits of the second, as PCL's recorder writes them.
 *
 * Shorter numbers count files.
 */
std::optional<std::chrono::nanoseconds>
stampOfName(const std::string& path);

/** \brief Times of files by their names. */
struct StampsOfFiles {
  std::vector<std::chrono::nanoseconds> stamps; ///< of each file; empty: they have none
  std::string problem; ///< why times that most names have are no times of the files
};

/** \brief The times of files in their order: those in the names if all have one and
 * each is later than the one before. */
StampsOfFiles
stampsOfNames(const std::vector<std::string>& paths);

/** \brief Whether a name is one that `pcl_ext decode` gives: the number of the frame in 6
 * digits or more, and after _ its time, if that is told. */
bool
isNameOfFrame(const std::string& path);

/** \brief Sorts files by the times in their names, if all have one: 1.5 before 1.45 is
 * wrong for those. Names of frames stay in the order of their numbers. */
void
sortByStamp(std::vector<std::string>& paths);

} // namespace clouds
} // namespace pcl_ext
