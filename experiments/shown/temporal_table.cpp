// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * The table of filters of outliers and over time: what they save, and what is shown.
 */
#include "experiments/tables.h"
#include "measured_sender.h"
#include "measuring/results.h"
#include "simulator/crop_box.h"

#include <pcl/conversions.h>

#include <algorithm>
#include <list>
#include <string>
#include <tuple>

namespace pcl_ext {
namespace experiments {

namespace {

using namespace shown;
using cell::RobotCell;

/** \brief Sensor 1 on the hand of a robot. */
constexpr unsigned int hand_camera = 8;

/** \brief Frames in which a filter over time knows nothing yet. */
constexpr std::size_t frames_to_learn = 20;

/** \brief The clouds of a sensor with what of them is of surfaces and of the person. */
class TrueClouds {
public:
  TrueClouds(std::uint32_t seed, unsigned int sensor)
  : cell_(seed), sensor_(sensor == hand_camera ? 1 : sensor)
  {
    if (sensor == hand_camera)
      cell_.moveSensor(sensor_, cell::handCamera);
  }

  bool
  isLidar() const
  {
    return sensor_ == RobotCell::lidar;
  }

  void
  read(std::uint32_t number)
  {
    if (isLidar()) {
      cell_.captureLidar(number, revolution_);
      pcl::toPCLPointCloud2(revolution_.cloud, cloud);
      pose = WorldPose(revolution_.pose);
      const std::vector<cell::Material>& materials =
          cell_.lidarSurfaces(number).material;
      surfaces = surfacePoints(revolution_, [&](std::size_t i) {
        return materials[i] == cell::Material::Cloth;
      });
      return;
    }
    cell_.capture(sensor_, number, frame_);
    pcl::toPCLPointCloud2(frame_.cloud, cloud);
    pose = WorldPose(frame_.pose);
    cell_.movers(movers_);
    surfaces = surfacePoints(
        frame_, [&](std::size_t i) { return movers_[i] == cell::Mover::Person; });
  }

  // Of the cloud that was read last.
  pcl::PCLPointCloud2 cloud;
  WorldPose pose;
  std::vector<SurfacePoint> surfaces;

private:
  RobotCell cell_;
  unsigned int sensor_;
  cell::CellFrame frame_;
  cell::LidarFrame revolution_;
  std::vector<cell::Mover> movers_;
};

nodes::SensorNodeSettings
nodeSettings(double edge, bool is_lidar)
{
  nodes::SensorNodeSettings settings;
  settings.compression.resolution = edge;
  settings.compression.effort = io::Effort::Balanced;
  settings.compression.i_frame_rate = 300;
  settings.law = is_lidar ? IntensityLaw::Native : IntensityLaw::Count;
  settings.crop_box = cell::cropBox();
  return settings;
}

void
addResults(const measuring::Subject& subject,
           const MeasuredSender& sender,
           double unfiltered_bytes,
           measuring::Results& results)
{
  results.add(subject, "bytes", sender.frame_bytes);
  results.add(subject,
              "of_unfiltered_percent",
              100.0 * sender.frame_bytes.sum() / unfiltered_bytes,
              sender.frame_bytes.count());
  for (const auto& [what, samples] : {std::tuple("surface", &sender.surface_percent),
                                      std::tuple("person", &sender.person_percent)}) {
    if (samples->count() == 0)
      continue;
    const std::string name = what;
    results.add(subject, name + "_percent", *samples);
    results.add(
        subject, name + "_worst_percent", samples->smallest(), samples->count());
  }
  results.add(subject, "noise_percent", sender.noise_percent);
  results.add(subject, "encode_ms", sender.encode_ms);
  results.add(subject, "decode_ms", sender.decode_ms);
}

void
measureSensor(const Options& options,
              unsigned int sensor,
              double edge,
              measuring::Results& results)
{
  TrueClouds clouds(options.seed, sensor);
  QualityJudge judge(edge);
  const RateTrace link = RateTrace::steady("without limit", 1e12);
  std::list<MeasuredSender> senders;
  for (const auto& [name, removes_outliers, filter] :
       {std::tuple("none", false, 0u),
        std::tuple("outliers", true, 0u),
        std::tuple("temporal", false, 8u),
        std::tuple("both", true, 8u)}) {
    nodes::SensorNodeSettings settings = nodeSettings(edge, clouds.isLidar());
    settings.compression.temporal_filter = filter;
    if (removes_outliers)
      settings.outlier_removal.emplace();
    senders.emplace_back(name, settings, link, judge);
    senders.back().first_judged = std::min(frames_to_learn, options.frames / 2);
  }
  const double interval =
      1.0 / (clouds.isLidar() ? RobotCell::lidar_rate : RobotCell::frame_rate);
  for (std::uint32_t i = 0; i < options.frames; ++i) {
    clouds.read(i);
    judge.add(clouds.surfaces);
    for (MeasuredSender& sender : senders)
      sender.send(clouds.cloud, clouds.pose, i * interval, (i + 1) * interval);
  }
  const std::string name = sensor == hand_camera ? "hand" : std::to_string(sensor);
  for (const MeasuredSender& sender : senders)
    addResults({"temporal", name, sender.name(), edge},
               sender,
               senders.front().frame_bytes.sum(),
               results);
}

} // namespace

void
measureTemporalFilter(const Options& options, std::ostream& output)
{
  measuring::Results results(output);
  for (const unsigned int sensor :
       options.sensorsOr({1, 2, 3, 4, 5, 6, 7, hand_camera}))
    for (const double edge : options.edgesOr({0.04}))
      measureSensor(options, sensor, edge, results);
}

} // namespace experiments
} // namespace pcl_ext
