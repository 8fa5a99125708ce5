// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/impl/health_report.h>
#include <pcl_ext/nodes/impl/merge_schedule.h>
#include <pcl_ext/nodes/impl/merged_source.h>
#include <pcl_ext/nodes/impl/node_parameters.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Settings of a MergingCentre. */
struct MergingCentreSettings {
  /** \brief Of decoding and of the common grid; max_merge_age is that of streams whose
   * clouds are stamped by another clock than the others'. */
  CentralNodeSettings node;

  /** \brief As faultOf() accepts; max_released is that which the node takes. */
  MergeScheduleSettings schedule;

  /** \brief Clock of arrivals, which is not set. */
  Clock arrival_clock = steadyTime;

  /** \brief Whether a stream of larger voxels than those of the common grid is
   * reported: not, where streams are never merged and there is no map. */
  bool reports_resolution = true;

  /** \brief Whether a thread of the centre calls work() when it is time; else the caller
   * does. */
  bool has_thread = true;

  /** \brief How long work() waits for frames that are being decoded and merges what is
   * due; the last merged frame may take longer. None: until nothing is due, as does a
   * thread of the centre. */
  std::optional<Time> turn;
};

/** \brief Streams were merged. Valid during the listener's call. */
struct MergedFrame {
  /** \brief Ok, or why there are no voxels. */
  const CentralNodeStatus& status;

  Time time; ///< of the clouds, as of which they were merged

  const MergedChanges& changes; ///< see CentralNode::mergeChanges

  /** \brief Gives all voxels, see CentralNode::merge; they are written when it is called
   * first. Throws std::bad_alloc without memory. */
  const std::function<const io::VoxelFrame&()>& voxels;

  /** \brief What the voxels are of: each stream, followed by its own sources. */
  const std::vector<MergedSource>& sources;

  /** \brief Streams that are merged as they arrive, as their clocks are more than 2 s
   * from the others'. */
  const std::set<std::string>& other_clocks;
};

/** \brief Called for each merged frame, by one thread at a time. Must not throw in a
 * centre that has a thread; else work() throws the same. */
using MergeListener = std::function<void(const MergedFrame&)>;

/** \brief What a centre does with the frames of its streams, whatever brings them: it
 * checks, decodes and denoises them, merges those that belong together in time, and
 * tells how all that goes. A stream may be that of another centre.
 *
 * All members are thread-safe. As CentralNode, it throws std::bad_alloc without memory.
 */
class PCL_EXT_EXPORT MergingCentre {
public:
  /** \param[in] settings see settingsStatus()
   * \param[in] on_frame called for each frame that was received, as by CentralNode; may
   * be empty
   * \param[in] on_merged may be empty
   */
  MergingCentre(const MergingCentreSettings& settings,
                FrameListener on_frame,
                MergeListener on_merged);

  /** \brief Waits until every frame is decoded. */
  ~MergingCentre();
  MergingCentre(const MergingCentre&) = delete;
  MergingCentre&
  operator=(const MergingCentre&) = delete;

  /** \brief Ok, or InvalidSettings with the setting; every other call then returns the
   * same, or does nothing. */
  const CentralNodeStatus&
  settingsStatus() const;

  /** \brief The streams as they are decoded. Streams are added and removed, and receive
   * frames, by the members below alone. */
  CentralNode&
  node();

  /** \brief Adds a stream; see CentralNode::addStream. */
  CentralNodeStatus
  addStream(const std::string& stream);

  /** \brief Removes a stream; see CentralNode::removeStream. */
  CentralNodeStatus
  removeStream(const std::string& stream);

  /** \brief Sets what is noise in all streams, as far as they have no values of their
   * own.
   * \param[in] values of noiseParameters(), each as convertedValue() returns it; one
   * that is missing has its default
   */
  void
  setNoise(const ParameterValues& values);

  /** \brief Sets what is noise in one stream.
   * \param[in] stream its name
   * \param[in] own values as above; for one that is missing that of all streams holds
   */
  void
  setNoise(const std::string& stream, const ParameterValues& own);

  /** \brief Whether streams are merged: no by default. While they are, frames that are
   * ahead of others wait to be decoded, see MergeSchedule. Once it is off, the listener
   * of merged frames is not called any more. Not to be called by that. */
  void
  setMerging(bool is_on);

  /** \brief A frame of a stream arrived that is not for this centre, as
   * faultOfMessage() says: it is counted. */
  void
  countLeftOut(const std::string& stream);

  /** \brief Takes a stream's next frame.
   * \param[in] stream its name
   * \param[in] bytes as of CentralNode::receive
   * \param[in] stamp of the cloud
   * \return Ok if it waits to be decoded; UnknownStream, or why it was refused
   */
  CentralNodeStatus
  receive(const std::string& stream, std::vector<std::uint8_t> bytes, Time stamp);

  /** \brief How many frames of a stream had the stamp of the one before, in place of
   * which their arrival counts, see MergeSchedule. */
  std::size_t
  stampsRepeated(const std::string& stream) const;

  /** \brief What the frames of a stream are merged of, which is another centre's merged
   * stream.
   * \param[in] stream its name
   * \param[in] time MergedFrame::time of the frame
   * \param[in] sources MergedFrame::sources; of more than 4096 the first ones, of longer
   * names the first 1024 bytes
   */
  void
  setSources(const std::string& stream, Time time, std::vector<MergedSource> sources);

  /** \brief How many merged frames there were; those that were left out are a sign that
   * the machine is too slow for the streams. */
  MergeCounts
  mergeCounts() const;

  /** \brief Decodes and merges what is due. To be called when a frame has arrived and
   * some times a MergeScheduleSettings::max_wait, unless the centre has a thread for
   * it. */
  void
  work();

  /** \brief No more frames come: merges all that have come, without waiting for others.
   * \param[in] longest as MergingCentreSettings::turn; merged frames that it leaves no time
   * for are counted as left out
   */
  void
  finish(std::optional<Time> longest);

  /** \brief Called with the report of a stream, to add to it. */
  using Amend = std::function<void(const std::string& stream, HealthReport& report)>;

  /** \brief Describes the streams, by name, and as "all streams" all of them. For one
   * thread at a time.
   * \param[in] map_nodes number of nodes of the map
   * \param[in] amend may be empty
   */
  std::vector<std::pair<std::string, HealthReport>>
  describeHealth(std::size_t map_nodes, const Amend& amend = Amend());

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
