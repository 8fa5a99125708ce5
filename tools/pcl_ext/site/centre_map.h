// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/impl/health_metrics.h>

#include "console/console.h"
#include "inputs/stream_metadata.h"

#include <memory>
#include <optional>
#include <string>

namespace pcl_ext::tools {

/** \brief An OctoMap that is fed with the streams of a site. */
struct CentreMapOptions {
  std::string path;         ///< of the .ot file; empty: no map
  bool may_replace = false; ///< a file that is there
  /** \brief Intensity that counts as one hit, in the unit of the streams; 0: each voxel
   * does; none: 0 for streams whose law is native, else 4. */
  std::optional<double> full_intensity;
  bool waits = false; ///< for each update, as a replay can
};

/** \brief Feeds the map: at the end of each second of the clouds' time, from the first
 * update() on, with the latest frames. That is done by a thread of its own, as it may
 * take longer than from one merged frame to the next; what it has no time for in the
 * second that follows is left out, and counted. */
class CentreMap {
public:
  /** \param[in] resolution metres
   * \param[in] console must outlive this
   * \throws UsageError if the map cannot be written
   */
  CentreMap(const CentreMapOptions& options, double resolution, Console& console);
  ~CentreMap();
  CentreMap(const CentreMap&) = delete;
  CentreMap&
  operator=(const CentreMap&) = delete;

  /** \brief Adds a stream, or has other metadata of it from a time of the clouds on; rays
   * are taken from the pose that they tell, and a hit is what suits their law. */
  void
  setMetadata(const std::string& name,
              const StreamMetadata& metadata,
              nodes::Time since);

  /** \brief Inserts the latest frames, if a second has ended and no others are being
   * inserted, for which a replay waits. Writes the map once a minute.
   * \param[in] node must outlive this
   * \param[in] time of the clouds
   * \throws std::runtime_error if it could not be written
   */
  void
  update(const nodes::CentralNode& node, nodes::Time time);

  /** \brief Inserts the last frames, unless that takes long or the program is
   * interrupted, and writes the map: not an empty one, and that of a part of a replay
   * beside an earlier one, with ".unfinished" added to its name.
   * \throws std::runtime_error
   */
  void
  finish(const nodes::CentralNode& node);

  /** \brief Whether the map was empty in the end, or lacks voxels, which was told. */
  bool
  isLeftOut() const;

  /** \brief Seconds whose frames were inserted, and those left out. Called by any thread.
   */
  nodes::MapCounts
  counts() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_; // null: no map
};

} // namespace pcl_ext::tools
