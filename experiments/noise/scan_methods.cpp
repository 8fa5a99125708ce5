#include "scan_methods.h"

#include <pcl_ext/filters/point_outlier_removal.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/point_intensity.h>

#include "clouds/label_files.h"
#include "measuring/markdown_table.h"
#include "point_filters.h"
#include "range_filters.h"

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace noise {

namespace {

using measuring::formatted;

ScanMethod
intensityMethod()
{
  return pointMethod("intensity",
                     [](const LabelledScan& scan, std::vector<float>& scores) {
                       scores.clear();
                       for (const pcl::PointXYZI& point : scan.cloud)
                         scores.push_back(point.intensity);
                     });
}

/** \brief What is near is noise: what any other method should be better than. */
ScanMethod
rangeMethod()
{
  return pointMethod("range", [](const LabelledScan& scan, std::vector<float>& scores) {
    scores.clear();
    for (const pcl::PointXYZI& point : scan.cloud)
      scores.push_back(point.getVector3fMap().norm());
  });
}

/** \brief VoxelOutlierRemoval, with the numbers of points for the unit Points. */
ScanMethod
removalMethod(const std::string& name, DensityUnit unit, bool use_history)
{
  VoxelOutlierRemovalSettings settings;
  settings.unit = unit;
  settings.use_history = use_history;
  return voxelMethod(
      name,
      [settings](double) {
        const auto removal = std::make_shared<VoxelOutlierRemoval>(settings);
        return [removal](const LabelledFrame& frame, std::vector<float>& scores) {
          removal->score(frame.of(Law::Count), scores);
        };
      },
      {0.0f, 1.0f, 2.0f});
}

/** \brief PointOutlierRemoval on the cloud, with its rows if it has them. */
ScanMethod
pointRemovalMethod(const std::string& name, bool use_history)
{
  PointOutlierRemovalSettings settings;
  settings.use_history = use_history;
  const auto removal = std::make_shared<PointOutlierRemoval>(settings);
  return pointMethod(
      name,
      [removal](const LabelledScan& scan, std::vector<float>& scores) {
        io::PointView view = pointViewOf(scan.cloud);
        if (scan.cloud.height > 1)
          view.image = {scan.cloud.width, scan.cloud.height};
        if (const auto status = removal->score(view, scores); !status.ok())
          throw std::runtime_error("scan '" + scan.name + "': " + status.message());
      },
      {0.0f, 1.0f, 2.0f});
}

ScanMethod
radiusOfRangeMethod(double multiplier, double azimuth_step)
{
  RangeRadius radius;
  radius.multiplier = multiplier;
  radius.azimuth_step = azimuth_step;
  return cloudMethod(
      "DROR " + formatted(multiplier, 0) + " steps",
      [radius](const Centres::ConstPtr& points, std::vector<float>& scores) {
        rangeRadiusScores(points, radius, scores);
      },
      {2.0f}); // the authors ask for three, the point itself among them
}

ScanMethod
statisticsOfRangeMethod(int neighbours)
{
  RangeStatistics statistics;
  statistics.neighbours = neighbours;
  return cloudMethod(
      "DSOR " + std::to_string(neighbours) + " neighbours",
      [statistics](const Centres::ConstPtr& points, std::vector<float>& scores) {
        rangeStatisticsScores(points, statistics, scores);
      },
      {-0.05f}); // the authors'
}

} // namespace

ScanMethod
pointMethod(const std::string& name,
            ScanMethod::PointScore score,
            std::vector<float> thresholds)
{
  return {name, std::move(score), {}, std::move(thresholds), false};
}

ScanMethod
cloudMethod(
    const std::string& name,
    const std::function<void(const Centres::ConstPtr&, std::vector<float>&)>& score,
    std::vector<float> thresholds)
{
  return pointMethod(
      name,
      [score, of_returns = std::vector<float>()](const LabelledScan& scan,
                                                 std::vector<float>& scores) mutable {
        score(scan.returns, of_returns);
        scores.assign(scan.cloud.size(), 0.0f);
        for (std::size_t i = 0; i < of_returns.size(); ++i)
          scores[scan.index_of_return[i]] = of_returns[i];
      },
      std::move(thresholds));
}

ScanMethod
voxelMethod(const std::string& name,
            std::function<Method::Score(double)> score,
            std::vector<float> thresholds)
{
  return {name, {}, std::move(score), std::move(thresholds), false};
}

ScanMethod
predictions(const std::string& folder, const LabelMeanings& meanings)
{
  ScanMethod method = pointMethod(
      "predictions",
      [folder, meanings](const LabelledScan& scan, std::vector<float>& scores) {
        const auto path = std::filesystem::path(folder) / (scan.name + ".label");
        scores.clear();
        for (const std::uint16_t label :
             clouds::readLabels(path.string(), scan.cloud.size()))
          scores.push_back(meanings.classOf(label) == PointClass::Noise ? 0.0f : 1.0f);
      },
      {0.5f});
  method.is_decision = true;
  return method;
}

std::vector<ScanMethod>
scanMethods(const RaySteps& steps)
{
  std::vector<ScanMethod> methods = {
      intensityMethod(),
      rangeMethod(),
      removalMethod("filter on voxels", DensityUnit::Voxels, true),
      removalMethod("filter on voxels without history", DensityUnit::Voxels, false),
      removalMethod("filter on counts", DensityUnit::Points, true),
      pointRemovalMethod("filter on points", true),
      pointRemovalMethod("filter on points without history", false)};
  for (const double multiplier : {3.0, 6.0, 10.0, 20.0})
    methods.push_back(radiusOfRangeMethod(multiplier, steps.azimuth));
  for (const int neighbours : {3, 5, 10, 20})
    methods.push_back(statisticsOfRangeMethod(neighbours));
  for (const int neighbours : {8, 26, 50})
    methods.push_back(cloudMethod(
        "StatisticalOutlierRemoval " + std::to_string(neighbours) + " neighbours",
        [neighbours](const Centres::ConstPtr& points, std::vector<float>& scores) {
          statisticalScores(points, neighbours, scores);
        }));
  for (const double radius : {0.1, 0.2, 0.4, 0.8})
    methods.push_back(cloudMethod(
        "RadiusOutlierRemoval " + formatted(radius, 1) + " m",
        [radius](const Centres::ConstPtr& points, std::vector<float>& scores) {
          radiusScores(points, radius, scores);
        }));
  return methods;
}

} // namespace noise
} // namespace pcl_ext
