// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/sensor_node.h>
#include <pcl_ext/nodes/stream_health.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief The levels of ROS's diagnostic_msgs/DiagnosticStatus, with its numbers. */
enum class HealthLevel : std::uint8_t { Ok = 0, Warning = 1, Error = 2, Stale = 3 };

/** \brief One entry of a node's diagnostics. */
class PCL_EXT_EXPORT HealthReport {
public:
  /** \brief Sets level and message, unless the level is as high already; errors are the
   * highest.
   * \param[in] level of the message
   * \param[in] message one sentence
   */
  void
  raise(HealthLevel level, const std::string& message);

  template <typename ValueT>
  void
  add(const std::string& key, const ValueT& value)
  {
    std::ostringstream text;
    text << value;
    values_.emplace_back(key, text.str());
  }

  HealthLevel
  level() const
  {
    return level_;
  }

  const std::string&
  message() const
  {
    return message_;
  }

  /** \brief Keys and values, in the order in which they were added. */
  const std::vector<std::pair<std::string, std::string>>&
  values() const
  {
    return values_;
  }

private:
  HealthLevel level_ = HealthLevel::Ok;
  std::string message_ = "OK";
  std::vector<std::pair<std::string, std::string>> values_;
};

/** \brief What is known of a node that encodes one stream. */
struct SenderHealth {
  SensorNodeStatistics node;
  std::size_t clouds = 0;                ///< received
  std::size_t clouds_missed = 0;         ///< that were lost before they were received
  std::size_t latest_transforms = 0;     ///< used, as there was none at the stamp
  std::size_t clouds_of_other_frame = 0; ///< dropped: another frame, unknown to TF
  std::size_t i_frame_requests = 0;      ///< received
  std::optional<Time> last_arrival;      ///< of a cloud; none: none arrived

  /** \brief Clouds that were left out for want of a transform. */
  std::size_t
  cloudsWithoutTransform() const
  {
    return node.clouds_without_transform + clouds_of_other_frame;
  }
};

/** \brief Describes the health of a stream where it is encoded.
 * \param[in] now as it is
 * \param[in] before as of the last report
 * \param[in] time current time of the clock of last_arrival
 */
PCL_EXT_EXPORT HealthReport
describeHealth(const SenderHealth& now, const SenderHealth& before, Time time);

/** \brief What is known of a stream where it is decoded. */
struct ReceiverHealth {
  StreamHealth stream;
  std::size_t left_out = 0; ///< frames of another frame id or format
  float min_intensity = 0.0f;
  std::optional<Time> last_arrival; ///< of a frame; none: none arrived
  /** \brief Voxel edge of the grid that the stream is merged on, and of the map, metres;
   * 0: none. */
  double merged_resolution = 0.0;
};

/** \brief Merged frames that faults are told of. */
enum class MergedFrames {
  Last,
  All ///< since the stream was added
};

/** \brief What of merged frames, or of the map, is not as the stream has it, a sentence
 * each.
 * \param[in] merged_resolution see ReceiverHealth
 * \param[in] frames of which; of all, the sentences have how many they are
 */
PCL_EXT_EXPORT std::vector<std::string>
faultsOfMerging(const StreamHealth& stream,
                double merged_resolution,
                MergedFrames frames = MergedFrames::Last);

/** \brief Describes the health of a stream where it is decoded; as above. */
PCL_EXT_EXPORT HealthReport
describeHealth(const ReceiverHealth& now, const ReceiverHealth& before, Time time);

/** \brief Describes the streams of a node together: a warning unless each is Ok.
 * \param[in] streams as CentralNode::health() has them
 * \param[in] are_ok whether the level of each stream's report is Ok
 * \param[in] map_nodes number of nodes of the map
 * \param[in] time current time of the node's clock
 */
PCL_EXT_EXPORT HealthReport
describeTogether(const std::vector<StreamHealth>& streams,
                 bool are_ok,
                 std::size_t map_nodes,
                 Time time);

} // namespace pcl_ext::PCL_EXT_ABI::nodes
