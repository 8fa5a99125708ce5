// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief How a sensor's node finds the pose of a cloud, and how long it waits for it;
 * whatever has the transforms, as tf2 of ROS 1 or ROS 2.
 */
#pragma once

#include <pcl_ext/nodes/impl/cloud_messages.h>
#include <pcl_ext/nodes/stream_health.h>
#include <pcl_ext/rigid_pose.h>

#include <algorithm>
#include <exception>
#include <optional>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Result of a search. */
struct FoundTransform {
  /** \brief Frame -> global frame, metres; nothing if there is no transform. */
  std::optional<WorldPose> pose;

  /** \brief There is none at the stamp; this is the latest. */
  bool is_latest = false;

  /** \brief Why there is none at the stamp. */
  std::string failure;
};

/** \brief Whether a transform has to be searched: not to the same frame, nor from an
 * empty one, of which tf2 prints a line each time.
 * \param[in] frame_id of a cloud, with or without a leading slash
 * \param[in] global_frame without one
 */
inline bool
needsTransform(const std::string& frame_id, const std::string& global_frame)
{
  const std::string frame = withoutLeadingSlash(frame_id);
  return !frame.empty() && frame != global_frame;
}

/** \brief The transform at the stamp of a cloud, else the latest, else none. That of the
 * global frame is the identity.
 * \param[in] frame_id of the cloud
 * \param[in] global_frame without a leading slash
 * \param[in] at_stamp takes the frame without a leading slash, returns its WorldPose or
 * throws std::exception
 * \param[in] latest likewise
 */
template <typename AtStampT, typename LatestT>
FoundTransform
findTransform(const std::string& frame_id,
              const std::string& global_frame,
              const AtStampT& at_stamp,
              const LatestT& latest)
{
  FoundTransform found;
  const std::string frame = withoutLeadingSlash(frame_id);
  if (frame.empty()) {
    found.failure = "the frame_id is empty";
    return found;
  }
  if (frame == global_frame) {
    found.pose = WorldPose::Identity();
    return found;
  }
  try {
    found.pose = at_stamp(frame);
    return found;
  }
  catch (const std::exception& failure) {
    found.failure = failure.what();
  }
  try {
    found.pose = latest(frame);
    found.is_latest = true;
  }
  catch (const std::exception&) {
    // The message of the first failure is kept.
  }
  return found;
}

/** \brief How long a cloud that has arrived waits for its transform. The time begins at
 * the stamp, so that waiting clouds do not add up theirs.
 * \param[in] timeout from the stamp on
 * \param[in] stamp of the cloud
 * \param[in] now time of the clock that stamps the clouds
 */
inline Time
transformWait(Time timeout, Time stamp, Time now)
{
  return std::clamp(timeout - (now - stamp), Time(0), timeout);
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
