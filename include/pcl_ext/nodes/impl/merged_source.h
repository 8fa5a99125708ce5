// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/nodes/impl/health_report.h>
#include <pcl_ext/nodes/stream_health.h>

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief A stream that a merged frame has voxels of, or lacks. */
struct MergedSource {
  /** \brief Its name at the centre that receives it. Behind "STREAM: " those of STREAM,
   * which is the merged stream of another centre. */
  std::string name;

  std::optional<Time> stamp; ///< of the cloud; none: it is missing, as it has no frame

  /** \brief Frames that did not become voxels between sender and centre, since the centre
   * has the stream: lost, failed, refused, or of another frame id or format. */
  std::size_t frames_dropped = 0;
};

/** \brief Describes what a merged frame has: by the name of each source the stamp and
 * age of its voxels and the frames that were dropped on the way, Stale if it is
 * missing; last, as "all streams", the oldest of them.
 * \param[in] sources of the frame
 * \param[in] now current time of the clock that stamps the clouds
 */
PCL_EXT_EXPORT std::vector<std::pair<std::string, HealthReport>>
describeMerged(const std::vector<MergedSource>& sources, Time now);

/** \brief The sources that were described.
 * \param[in] reports names, and keys and values of HealthReport::values(); any
 */
PCL_EXT_EXPORT std::vector<MergedSource>
readMergedSources(
    const std::vector<
        std::pair<std::string, std::vector<std::pair<std::string, std::string>>>>&
        reports);

} // namespace pcl_ext::PCL_EXT_ABI::nodes
