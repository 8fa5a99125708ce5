// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * The table of rate control over simulated links, beside fixed settings: what a receiver
 * shows of the robot cell, and how old it is.
 */
#include "experiments/tables.h"
#include "measured_sender.h"
#include "measuring/markdown_table.h"
#include "simulator/crop_box.h"

#include <pcl/conversions.h>

#include <algorithm>
#include <cstddef>
#include <list>
#include <ostream>
#include <string>
#include <vector>

namespace pcl_ext {
namespace experiments {

namespace {

using namespace shown;
using measuring::formatted;

/** \brief Of sensor 1 unless another is asked for, and the finest voxel edge, metres. */
unsigned int
sensorOf(const Options& options)
{
  return options.sensorsOr({1}).front();
}

double
edgeOf(const Options& options)
{
  return options.edgesOr({0.02}).front();
}

std::vector<RateTrace>
traces(const Options& options)
{
  constexpr double mega = 1e6;
  std::vector<RateTrace> all;
  for (const double rate : options.rates)
    all.push_back(RateTrace::steady("steady " + formatted(rate, 2), mega * rate));
  if (options.wireless > 0.0)
    all.push_back(RateTrace::wireless("Wi-Fi to " + formatted(options.wireless, 2),
                                      mega * options.wireless,
                                      static_cast<double>(options.frames) /
                                          cell::RobotCell::frame_rate,
                                      options.seed));
  return all;
}

nodes::SensorNodeSettings
nodeSettings(double resolution)
{
  nodes::SensorNodeSettings settings;
  settings.compression.resolution = resolution;
  settings.compression.effort = io::Effort::Fast;
  settings.law = IntensityLaw::Count;
  settings.crop_box = cell::cropBox();
  settings.outlier_removal.emplace();
  return settings;
}

/** \brief The fixed settings among which the best is looked for. */
void
addFixedSenders(const Options& options,
                const RateTrace& trace,
                QualityJudge& judge,
                std::list<MeasuredSender>& senders)
{
  for (const int multiple : {1, 2, 4})
    for (const unsigned int filter : {0u, 8u})
      for (const unsigned int bits : {0u, 4u}) {
        nodes::SensorNodeSettings settings = nodeSettings(multiple * edgeOf(options));
        settings.compression.temporal_filter = filter;
        settings.compression.intensity_bits = bits;
        if (bits > 0)
          settings.compression.intensity_curve = io::IntensityCurve::Companded;
        senders.emplace_back(formatted(100.0 * settings.compression.resolution, 0) +
                                 " cm" + (filter > 0 ? ", filter" : "") +
                                 (bits > 0 ? ", 4 bits" : ""),
                             settings,
                             trace,
                             judge);
      }
}

/** \brief All senders of a link. */
void
addSenders(const Options& options,
           const RateTrace& trace,
           QualityJudge& judge,
           std::list<MeasuredSender>& senders)
{
  addFixedSenders(options, trace, judge, senders);
  nodes::SensorNodeSettings settings = nodeSettings(edgeOf(options));
  settings.compression.max_rate = trace.at(0.0);
  settings.compression.rate_buffer = options.rate_buffer;
  senders.emplace_back("**max_rate**", settings, trace, judge);
  settings.compression.rate_temporal_filter = 0;
  senders.emplace_back("max_rate, no filter", settings, trace, judge);
  settings.compression.rate_sent_share = 1.0;
  senders.emplace_back("max_rate, no filter, each cloud", settings, trace, judge);
}

/** \brief Surfaces shown, less what is shown that is none. */
double
scoreOf(const MeasuredSender& sender)
{
  return sender.surface_percent.mean() - sender.noise_percent.mean();
}

/** \brief Milliseconds that so many of a thousand frames have arrived within. */
std::string
arrivalAge(const MeasuredSender& sender, std::size_t per_mille)
{
  const measuring::Samples& ages = sender.arrival_ages;
  return formatted(1e3 * ages.percentile(per_mille).value_or(ages.largest()), 0);
}

void
print(const RateTrace& trace,
      const std::list<MeasuredSender>& senders,
      std::ostream& output)
{
  double best = -100.0;
  for (const MeasuredSender& sender : senders)
    if (!sender.hasBudget())
      best = std::max(best, scoreOf(sender));
  measuring::MarkdownTable table({trace.name() + " Mbit/s",
                                  "surfaces %",
                                  "noise %",
                                  "score",
                                  "kbit a frame",
                                  "largest second",
                                  "left out",
                                  "age p50, ms",
                                  "p99",
                                  "changes"});
  for (const MeasuredSender& sender : senders)
    table.addRow({sender.name() +
                      (!sender.hasBudget() && scoreOf(sender) == best ? " (best)" : ""),
                  formatted(sender.surface_percent.mean(), 1),
                  formatted(sender.noise_percent.mean(), 1),
                  formatted(scoreOf(sender), 1),
                  formatted(sender.frame_bytes.mean() * 8e-3, 1),
                  formatted(100.0 * sender.largest_load, 1) + " %",
                  std::to_string(sender.clouds_left_out),
                  arrivalAge(sender, 500),
                  arrivalAge(sender, 990),
                  sender.hasBudget() ? std::to_string(sender.changes()) : ""});
  table.print(output);
  output << '\n';
}

} // namespace

void
printRateControl(const Options& options, std::ostream& output)
{
  const double interval = 1.0 / cell::RobotCell::frame_rate;
  const std::vector<RateTrace> links = traces(options);
  QualityJudge judge(edgeOf(options));
  std::vector<std::list<MeasuredSender>> senders(links.size());
  for (std::size_t i = 0; i < links.size(); ++i)
    addSenders(options, links[i], judge, senders[i]);
  cell::RobotCell cell(options.seed);
  cell::CellFrame frame;
  pcl::PCLPointCloud2 cloud;
  for (std::uint32_t i = 0; i < options.frames; ++i) {
    if (options.changes_scene && i == options.frames / 2)
      cell.moveSensor(sensorOf(options), cell::handCamera);
    cell.capture(sensorOf(options), i, frame);
    judge.add(surfacePoints(frame, [](std::size_t) { return false; }));
    pcl::toPCLPointCloud2(frame.cloud, cloud);
    const double time = i * interval;
    for (std::list<MeasuredSender>& of_link : senders)
      for (MeasuredSender& sender : of_link)
        sender.send(cloud, WorldPose(frame.pose), time, time + interval);
  }
  for (std::size_t i = 0; i < links.size(); ++i)
    print(links[i], senders[i], output);
}

} // namespace experiments
} // namespace pcl_ext
