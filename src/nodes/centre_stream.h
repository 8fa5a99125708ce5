// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/impl/health_report.h>
#include <pcl_ext/nodes/impl/merged_source.h>
#include <pcl_ext/nodes/impl/node_parameters.h>

#include <algorithm>
#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <utility>
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
  applyNoise(const std::string& name, CentralNode& node)
  {
    ParameterValues noise = own_noise_;
    noise.insert(noise_of_all_.begin(), noise_of_all_.end());
    if (noise_ == noise)
      return;
    const NoiseSettings settings = readNoiseParameters(noise);
    node.setMinIntensity(name, settings.lowestIntensity());
    node.setOutlierRemoval(name, settings.outlier_removal);
    node.setPacked(name, settings.is_packed);
    noise_ = std::move(noise);
  }

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
  setSources(Time time, std::vector<MergedSource> sources)
  {
    if (sources.size() > most_sources)
      sources.resize(most_sources);
    for (MergedSource& source : sources)
      if (source.name.size() > longest_name)
        source.name.resize(longest_name);
    sources_.push_back({time, std::move(sources)});
    if (sources_.size() > most_frames_with_sources)
      sources_.pop_front();
  }

  /** \brief Adds the stream and its own sources to those of a merged frame.
   * \param[in] merged the stream in it
   * \param[in] health of all streams
   * \param[out] sources to add to
   */
  void
  addSources(const MergedStream& merged,
             const std::vector<StreamHealth>& health,
             std::vector<MergedSource>& sources) const
  {
    MergedSource& stream = sources.emplace_back();
    stream.name = merged.name;
    if (merged.frame)
      stream.stamp = merged.frame->stamp;
    stream.frames_dropped = left_out_;
    for (const StreamHealth& one : health)
      if (one.name == merged.name)
        stream.frames_dropped +=
            one.frames_lost + one.frames_failed + one.frames_dropped;
    if (sources_.empty())
      return;
    const auto of_frame = std::find_if(
        sources_.rbegin(), sources_.rend(), [&](const FrameSources& frame) {
          return merged.frame && frame.time == merged.frame->stamp;
        });
    const FrameSources& known =
        of_frame == sources_.rend() ? sources_.back() : *of_frame;
    for (MergedSource source : known.sources) {
      source.name = merged.name + ": " + source.name;
      if (!merged.frame)
        source.stamp.reset();
      sources.push_back(std::move(source));
    }
  }

  /** \brief Describes the stream since the last call.
   * \param[in] health in the central node
   * \param[in] merged_resolution as of ReceiverHealth
   * \param[in] now of the clock of arrivals
   */
  HealthReport
  describe(const StreamHealth& health, double merged_resolution, Time now)
  {
    ReceiverHealth current;
    current.stream = health;
    current.left_out = left_out_;
    current.last_arrival = last_arrival_;
    current.merged_resolution = merged_resolution;
    if (noise_)
      current.min_intensity = readNoiseParameters(*noise_).min_intensity;
    HealthReport report =
        describeHealth(current, std::exchange(reported_, current), now);
    if (stamps_repeated_ != std::exchange(reported_stamps_repeated_, stamps_repeated_))
      report.raise(HealthLevel::Warning,
                   "Frames have the stamp of the one before: they are merged as they "
                   "arrive");
    if (sources_.empty())
      return report;
    const std::vector<MergedSource>& sources = sources_.back().sources;
    std::size_t missing = 0;
    std::string names;
    for (const MergedSource& source : sources)
      if (!source.stamp) {
        if (missing < most_names)
          names += (missing == 0 ? "" : ", ") + source.name;
        ++missing;
      }
    report.add("sources", sources.size());
    report.add("sources missing", missing);
    if (missing > most_names)
      names += " and " + std::to_string(missing - most_names) + " more";
    if (missing > 0)
      report.raise(HealthLevel::Warning, "Sources are missing: " + names);
    return report;
  }

private:
  // Frames and what they are merged of come by different ways.
  static constexpr std::size_t most_frames_with_sources = 16;
  // Of any program that can send messages.
  static constexpr std::size_t most_sources = 4096;
  static constexpr std::size_t longest_name = 1024;
  static constexpr std::size_t most_names = 5; // in a message

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
