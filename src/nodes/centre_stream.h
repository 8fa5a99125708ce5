// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/impl/health_report.h>
#include <pcl_ext/nodes/impl/merged_source.h>
#include <pcl_ext/nodes/impl/node_parameters.h>

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief What a MergingCentre knows of one stream besides its CentralNode. For one
 * thread at a time. */
class CentreStream {
public:
  void
  setNoiseOfAll(const ParameterValues& values)
  {
    noise_of_all_ = values;
  }

  /** \brief These values hold instead of those of all. */
  void
  setOwnNoise(const ParameterValues& values)
  {
    own_noise_ = values;
  }

  /** \brief Passes what is noise on to the central node, if it has changed. */
  void
  applyNoise(const std::string& name, CentralNode& node);

  void
  countArrival(Time now)
  {
    last_arrival_ = now;
  }

  void
  countLeftOut(Time now)
  {
    last_arrival_ = now;
    ++left_out_;
  }

  /** \brief A frame had the stamp of the one before, in place of which its arrival
   * counts. */
  void
  countRepeatedStamp()
  {
    ++stamps_repeated_;
  }

  std::size_t
  stampsRepeated() const
  {
    return stamps_repeated_;
  }

  /** \brief What a frame of the stream is merged of, if it is that of another centre. */
  void
  setSources(Time time, std::vector<MergedSource> sources);

  /** \brief Adds the stream and its own sources to those of a merged frame.
   * \param[in] merged the stream in it
   * \param[in] health of all streams
   * \param[out] sources to add to
   */
  void
  addSources(const MergedStream& merged,
             const std::vector<StreamHealth>& health,
             std::vector<MergedSource>& sources) const;

  /** \brief Describes the stream since the last call.
   * \param[in] health in the central node
   * \param[in] merged_resolution as of ReceiverHealth
   * \param[in] now of the clock of arrivals
   */
  HealthReport
  describe(const StreamHealth& health, double merged_resolution, Time now);

private:
  struct FrameSources {
    Time time;
    std::vector<MergedSource> sources;
  };

  ParameterValues noise_of_all_;
  ParameterValues own_noise_;
  std::optional<ParameterValues> noise_; // that of the central node

  std::optional<Time> last_arrival_;
  std::size_t left_out_ = 0;
  std::size_t stamps_repeated_ = 0;
  std::deque<FrameSources>
      sources_; // of the last frames, in the order of their arrival
  ReceiverHealth reported_;
  std::size_t reported_stamps_repeated_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
