// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/centre_stream.h"

#include <algorithm>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

// Frames and what they are merged of come by different ways.
constexpr std::size_t most_frames_with_sources = 16;
// Of any program that can send messages.
constexpr std::size_t most_sources = 4096;
constexpr std::size_t longest_name = 1024;
constexpr std::size_t most_names = 5; // in a message

std::size_t
droppedOf(const StreamHealth& health)
{
  return health.frames_lost + health.frames_failed + health.frames_dropped;
}

} // namespace

void
CentreStream::applyNoise(const std::string& name, CentralNode& node)
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
CentreStream::setSources(Time time, std::vector<MergedSource> sources)
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

void
CentreStream::addSources(const MergedStream& merged,
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
      stream.frames_dropped += droppedOf(one);
  if (sources_.empty())
    return;
  const auto of_frame =
      std::find_if(sources_.rbegin(), sources_.rend(), [&](const FrameSources& frame) {
        return merged.frame && frame.time == merged.frame->stamp;
      });
  const FrameSources& known = of_frame == sources_.rend() ? sources_.back() : *of_frame;
  for (MergedSource source : known.sources) {
    source.name = merged.name + ": " + source.name;
    if (!merged.frame)
      source.stamp.reset();
    sources.push_back(std::move(source));
  }
}

HealthReport
CentreStream::describe(const StreamHealth& health, double merged_resolution, Time now)
{
  ReceiverHealth current;
  current.stream = health;
  current.left_out = left_out_;
  current.last_arrival = last_arrival_;
  current.merged_resolution = merged_resolution;
  if (noise_)
    current.min_intensity = readNoiseParameters(*noise_).min_intensity;
  HealthReport report = describeHealth(current, std::exchange(reported_, current), now);
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

} // namespace pcl_ext::PCL_EXT_ABI::nodes
