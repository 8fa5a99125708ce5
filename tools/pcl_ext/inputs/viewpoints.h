// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief VIEWPOINTs of PCD files, which a recording keeps for the files that it is
 * decoded to.
 */
#pragma once

#include <pcl_ext/recording/recording_status.h>

#include "clouds/pcd_file.h"
#include "inputs/stream_metadata.h"

#include <map>
#include <string>

namespace pcl_ext::tools {

using clouds::Viewpoint;

/** \brief The viewpoints of a stream's clouds. */
class Viewpoints {
public:
  /** \brief No viewpoints: all are that of files without one. */
  Viewpoints() = default;

  /** \brief Those that the metadata of a recorded stream has; none if it is invalid. */
  explicit Viewpoints(const StreamMetadata& metadata);

  /** \brief Adds that of the next cloud.
   * \param[in] time of the cloud
   * \param[in] text line VIEWPOINT of its file, x y z qw qx qy qz; ignored if it is
   * invalid
   */
  void
  add(recording::Time time, const std::string& text);

  /** \brief Adds those of another recording's clouds, which are later.
   * \param[in] first,last times of the clouds
   */
  void
  append(const Viewpoints& later, recording::Time first, recording::Time last);

  /** \brief True if all are that of files without one. */
  bool
  areDefault() const;

  /** \brief That of a cloud. */
  Viewpoint
  at(recording::Time time) const;

  /** \brief Adds them to a stream's metadata, unless areDefault(). */
  void
  addTo(StreamMetadata& metadata) const;

private:
  /** \brief That of a cloud, as add() takes it. */
  std::string
  textAt(recording::Time time) const;

  /** By the time from which on it holds: x,y,z,qw,qx,qy,qz. */
  std::map<recording::Time, std::string> changes_;
};

} // namespace pcl_ext::tools
