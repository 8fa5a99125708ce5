/** \file
 * \brief Measures rate control over simulated links, beside fixed settings: what a receiver
 * shows of the robot cell, and how old it is.
 */
#include "measured_sender.h"
#include "measuring/command_line.h"
#include "measuring/markdown_table.h"
#include "simulator/crop_box.h"

#include <pcl/conversions.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iostream>
#include <limits>
#include <list>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::rate;
using measuring::formatted;

struct RateOptions {
  unsigned int sensor = 1;
  std::uint32_t frames = 300;
  std::uint32_t seed = 1;
  double resolution = 0.02;
  std::vector<double> rates = {20.0, 5.0, 1.0};
  double wireless = 8.0;
  double rate_buffer = io::RateSettings().rate_buffer;
  bool changes_scene = false;
  bool has_budget_only = false;
};

void
addOptions(CLI::App& program, RateOptions& options)
{
  program.option_defaults()->always_capture_default();
  program.add_option("--sensor", options.sensor, "1 to 6")->check(CLI::Range(1, 6));
  program.add_option("--frames,-n", options.frames, "number of frames at 20 Hz")
      ->check(CLI::Range(20, 100000));
  program.add_option("--seed", options.seed, "of cell and link");
  program
      .add_option("--resolution,-r", options.resolution, "finest voxel edge, metres")
      ->check(CLI::Range(0.01, 0.1));
  program.add_option("--rates", options.rates, "of steady links, Mbit/s")
      ->check(CLI::Range(0.001, 1e6));
  program
      .add_option(
          "--wireless", options.wireless, "highest rate of a Wi-Fi, Mbit/s; 0: none")
      ->check(CLI::Range(0.0, 1e6));
  program.add_option("--rate-buffer", options.rate_buffer, "with max_rate, seconds")
      ->check(CLI::Range(0.01, 1.0));
  program.add_flag("--budget-only",
                   options.has_budget_only,
                   "without the fixed settings among which the best is looked for");
  program.add_flag("--change",
                   options.changes_scene,
                   "from the middle on the sensor is the camera on a hand");
}

std::vector<RateTrace>
traces(const RateOptions& options)
{
  constexpr double mega = 1e6;
  std::vector<RateTrace> all;
  for (const double rate : options.rates)
    all.push_back(RateTrace::steady("steady " + formatted(rate, 2), mega * rate));
  if (options.wireless > 0.0)
    all.push_back(RateTrace::wireless("Wi-Fi to " + formatted(options.wireless, 2),
                                      mega * options.wireless,
                                      options.frames / cell::RobotCell::frame_rate,
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
addFixedSenders(const RateOptions& options,
                const RateTrace& trace,
                QualityJudge& judge,
                std::list<MeasuredSender>& senders)
{
  for (const int multiple : {1, 2, 4})
    for (const unsigned int filter : {0u, 8u})
      for (const unsigned int bits : {0u, 4u}) {
        nodes::SensorNodeSettings settings =
            nodeSettings(multiple * options.resolution);
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
addSenders(const RateOptions& options,
           const RateTrace& trace,
           QualityJudge& judge,
           std::list<MeasuredSender>& senders)
{
  if (!options.has_budget_only)
    addFixedSenders(options, trace, judge, senders);
  nodes::SensorNodeSettings settings = nodeSettings(options.resolution);
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

double
percentile(std::vector<double> values, double share)
{
  if (values.empty())
    return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const auto rank =
      static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values[std::max<std::size_t>(rank, 1) - 1];
}

void
print(const RateTrace& trace, const std::list<MeasuredSender>& senders)
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
                  formatted(1e3 * percentile(sender.arrival_ages, 0.5), 0),
                  formatted(1e3 * percentile(sender.arrival_ages, 0.99), 0),
                  sender.hasBudget() ? std::to_string(sender.changes()) : ""});
  table.print(std::cout);
  std::cout << '\n';
}

void
measure(const RateOptions& options)
{
  const double interval = 1.0 / cell::RobotCell::frame_rate;
  const std::vector<RateTrace> links = traces(options);
  QualityJudge judge(options.resolution);
  std::vector<std::list<MeasuredSender>> senders(links.size());
  for (std::size_t i = 0; i < links.size(); ++i)
    addSenders(options, links[i], judge, senders[i]);
  cell::RobotCell cell(options.seed);
  cell::CellFrame frame;
  pcl::PCLPointCloud2 cloud;
  for (std::uint32_t i = 0; i < options.frames; ++i) {
    if (options.changes_scene && i == options.frames / 2)
      cell.moveSensor(options.sensor, cell::handCamera);
    cell.capture(options.sensor, i, frame);
    judge.add(frame);
    pcl::toPCLPointCloud2(frame.cloud, cloud);
    const double time = i * interval;
    for (std::list<MeasuredSender>& of_link : senders)
      for (MeasuredSender& sender : of_link)
        sender.send(cloud, WorldPose(frame.pose), time, time + interval);
  }
  for (std::size_t i = 0; i < links.size(); ++i)
    print(links[i], senders[i]);
}

} // namespace

int
main(int argc, char** argv)
{
  CLI::App program(
      "Measures rate control over simulated links, beside the best fixed setting: the "
      "share of the robot cell's surfaces that a receiver shows when the next cloud "
      "comes, the noise among what it shows, and the frames' age when they arrive.",
      "measure_rate");
  RateOptions options;
  addOptions(program, options);
  return measuring::runProgram(program, argc, argv, [&] { measure(options); });
}
