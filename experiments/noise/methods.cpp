// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "methods.h"

#include <pcl_ext/filters/point_outlier_removal.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/impl/point_intensity.h>

#include "measuring/markdown_table.h"

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace noise {

namespace {

using measuring::formatted;

/** \brief Log-odds that users set. */
const std::vector<float> wanted_log_odds = {0.0f, 2.5f};

/** \brief Between neighbouring rays of the cell's lidar, degrees: in a ring, and from
 * ring to ring. */
constexpr double azimuth_step = 0.2;
constexpr double ring_step = 2.0;

/** \brief One of the paper's laws: low intensities are noise. */
Method
lawMethod(Law law)
{
  return {nameOf(law),
          [law](const LabelledFrame& frame, std::vector<float>& scores) {
            const io::VoxelFrame& voxels = frame.of(law);
            scores.clear();
            for (const std::uint16_t symbol : voxels.intensities)
              scores.push_back(voxels.intensity_scale.value(symbol));
          },
          {},
          {}};
}

/** \brief VoxelOutlierRemoval on the intensities of a law. */
Method
filterMethod(const std::string& name,
             Law law,
             const VoxelOutlierRemovalSettings& settings)
{
  const auto removal = std::make_shared<VoxelOutlierRemoval>(settings);
  return {name,
          [removal, law](const LabelledFrame& frame, std::vector<float>& scores) {
            removal->score(frame.of(law), scores);
          },
          wanted_log_odds,
          {}};
}

VoxelOutlierRemovalSettings
settingsOf(DensityUnit unit, bool use_history = true)
{
  return {densityUnitSettings(unit, {{use_history}})};
}

VoxelOutlierRemovalSettings
settingsOfRays()
{
  constexpr double degree = 0.017453292519943295;
  return {RaysUnit{{}, degree * azimuth_step, degree * ring_step, true}};
}

/** \brief One of PCL's filters on the centres of voxels. */
template <typename ScoreT>
Method
centresMethod(const std::string& name, const ScoreT& score)
{
  return {name,
          [score](const LabelledFrame& frame, std::vector<float>& scores) {
            score(centresOf(frame.of(Law::Count)), scores);
          },
          {},
          {}};
}

/** \brief PointOutlierRemoval on the rows and columns of a scan. */
Method
pointRemovalMethod()
{
  const auto removal = std::make_shared<PointOutlierRemoval>();
  return {"filter on points",
          {},
          wanted_log_odds,
          [removal, of_all = std::vector<float>()](const LabelledScan& scan,
                                                   std::vector<float>& scores) mutable {
            const auto& cloud = scan.frame.cloud;
            io::PointView view = pointViewOf(cloud);
            view.image = {cloud.width, cloud.height};
            if (const auto status = removal->score(view, of_all); !status.ok())
              throw std::runtime_error(status.message());
            scores.clear();
            for (const std::size_t i : scan.index_of_return)
              scores.push_back(of_all[i]);
          }};
}

Method
intensityMethod()
{
  return {
      "intensity", {}, {}, [](const LabelledScan& scan, std::vector<float>& scores) {
        scores.clear();
        for (const pcl::PointXYZI& point : *scan.returns)
          scores.push_back(point.intensity);
      }};
}

Method
radiusOfRangeMethod(double multiplier)
{
  RangeRadius radius;
  radius.multiplier = multiplier;
  radius.azimuth_step = azimuth_step;
  return {"DROR " + formatted(multiplier, 0) + " steps",
          {},
          {2.0f}, // the authors ask for three, the point itself among them
          [radius](const LabelledScan& scan, std::vector<float>& scores) {
            rangeRadiusScores(scan.returns, radius, scores);
          }};
}

Method
statisticsOfRangeMethod(int neighbours)
{
  RangeStatistics statistics;
  statistics.neighbours = neighbours;
  return {"DSOR " + std::to_string(neighbours) + " neighbours",
          {},
          {-0.05f}, // the authors'
          [statistics](const LabelledScan& scan, std::vector<float>& scores) {
            rangeStatisticsScores(scan.returns, statistics, scores);
          }};
}

} // namespace

std::vector<Method>
cameraMethods(double edge)
{
  std::vector<Method> methods;
  for (const Law law : camera_laws)
    methods.push_back(lawMethod(law));
  methods.push_back(filterMethod(
      "filter on quadratic", Law::Quadratic, settingsOf(DensityUnit::Faces)));
  methods.push_back(filterMethod("filter on quadratic without history",
                                 Law::Quadratic,
                                 settingsOf(DensityUnit::Faces, false)));
  methods.push_back(
      filterMethod("filter on count", Law::Count, settingsOf(DensityUnit::Points)));
  methods.push_back(
      filterMethod("filter on voxels", Law::Count, settingsOf(DensityUnit::Voxels)));
  for (const int neighbours : {8, 26})
    methods.push_back(centresMethod(
        "StatisticalOutlierRemoval " + std::to_string(neighbours) + " neighbours",
        [neighbours](const Centres::ConstPtr& centres, std::vector<float>& scores) {
          statisticalScores(centres, neighbours, scores);
        }));
  // Between the distances to which voxels' centres can be apart.
  for (const double voxels : {1.8, 2.5})
    methods.push_back(
        centresMethod("RadiusOutlierRemoval " + formatted(voxels, 1) + " voxels",
                      [radius = voxels * edge](const Centres::ConstPtr& centres,
                                               std::vector<float>& scores) {
                        radiusScores(centres, radius, scores);
                      }));
  return methods;
}

std::vector<Method>
lidarMethods()
{
  std::vector<Method> methods = {
      intensityMethod(),
      pointRemovalMethod(),
      filterMethod("filter on rays", Law::Count, settingsOfRays()),
      filterMethod("filter on voxels", Law::Count, settingsOf(DensityUnit::Voxels)),
      filterMethod("filter on count", Law::Count, settingsOf(DensityUnit::Points))};
  for (const double multiplier : {3.0, 10.0})
    methods.push_back(radiusOfRangeMethod(multiplier));
  for (const int neighbours : {5, 10})
    methods.push_back(statisticsOfRangeMethod(neighbours));
  return methods;
}

std::vector<Method>
methodsNamed(const std::vector<std::string>& words, std::vector<Method> methods)
{
  const auto isUnwanted = [&](const Method& method) {
    return !words.empty() &&
           std::none_of(words.begin(), words.end(), [&](const std::string& word) {
             return method.name.find(word) != std::string::npos;
           });
  };
  methods.erase(std::remove_if(methods.begin(), methods.end(), isUnwanted),
                methods.end());
  if (methods.empty())
    throw std::invalid_argument("--methods: no method has a name with '" +
                                words.front() + "' in it");
  return methods;
}

} // namespace noise
} // namespace pcl_ext
