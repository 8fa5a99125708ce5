#include "methods.h"

#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "measuring/markdown_table.h"
#include "point_filters.h"

#include <algorithm>
#include <memory>
#include <utility>

namespace pcl_ext {
namespace noise {

namespace {

const std::vector<float> wanted_log_odds = {0.0f, 1.0f, 2.0f, 2.5f, 3.0f, 4.0f, 5.0f};

Method
lawMethod(Law law, std::vector<float> thresholds)
{
  Method method;
  method.name = nameOf(law);
  method.score = [law](const LabelledFrame& frame, std::vector<float>& scores) {
    const io::VoxelFrame& voxels = frame.of(law);
    scores.clear();
    for (const std::uint16_t symbol : voxels.intensities)
      scores.push_back(voxels.intensity_scale.value(symbol));
  };
  method.thresholds = std::move(thresholds);
  return method;
}

/** \brief The paper's laws: low intensities are noise. */
std::vector<Method>
lawMethods()
{
  const std::vector<float> shares = {13, 26, 38, 51, 64, 77, 102, 128, 191, 255};
  return {lawMethod(Law::Count, {2, 3, 4, 5, 7, 10, 15, 20}),
          lawMethod(Law::Quadratic, shares),
          lawMethod(Law::Linear, shares)};
}

VoxelOutlierRemovalSettings
settingsOf(Law law)
{
  VoxelOutlierRemovalSettings settings;
  settings.unit = densityUnitOf(law);
  return settings;
}

Method
filterMethod(Law law,
             const std::string& what_else,
             const VoxelOutlierRemovalSettings& settings)
{
  const auto removal = std::make_shared<VoxelOutlierRemoval>(settings);
  return {"filter on " + nameOf(law) + what_else,
          [removal, law](const LabelledFrame& frame, std::vector<float>& scores) {
            removal->score(frame.of(law), scores);
          },
          wanted_log_odds,
          {}};
}

Method
filterMethod(Law law)
{
  return filterMethod(law, "", settingsOf(law));
}

/** \brief The filter without intensities. */
Method
filterOnVoxels()
{
  Method method = filterMethod(Law::Count, "", settingsOf(Law::Native));
  method.name = "filter on voxels";
  return method;
}

Method
filterWithoutHistory(VoxelOutlierRemovalSettings settings)
{
  settings.use_history = false;
  return filterMethod(Law::Quadratic, " without history", settings);
}

Method
sensorsAloneMethod(const MergedStream& stream)
{
  const auto removals =
      std::make_shared<std::vector<VoxelOutlierRemoval>>(cell::RobotCell::sensor_count);
  Method method;
  method.name = "filter on quadratic of each sensor";
  method.thresholds = wanted_log_odds;
  method.score = [removals, &stream](const LabelledFrame& merged,
                                     std::vector<float>& scores) {
    const auto& keys = merged.of(Law::Quadratic).keys;
    scores.assign(keys.size(), -1e9f);
    std::vector<float> of_sensor;
    for (std::size_t sensor = 0; sensor < removals->size(); ++sensor) {
      const io::VoxelFrame& voxels = stream.sensorFrames()[sensor].of(Law::Quadratic);
      (*removals)[sensor].score(voxels, of_sensor);
      std::size_t at = 0;
      for (std::size_t i = 0; i < of_sensor.size(); ++i) {
        while (keys[at] != voxels.keys[i])
          ++at;
        scores[at] = std::max(scores[at], of_sensor[i]);
      }
    }
  };
  return method;
}

} // namespace

std::vector<Method>
cameraMethods()
{
  std::vector<Method> methods = lawMethods();
  methods.push_back(filterMethod(Law::Quadratic));
  methods.push_back(filterWithoutHistory({}));
  methods.push_back(filterMethod(Law::Linear));
  methods.push_back(filterMethod(Law::Count));
  methods.push_back(filterOnVoxels());
  return methods;
}

std::vector<Method>
mergedMethods(const MergedStream& stream)
{
  // The unit is set, as merged frames have no depth model that implies it.
  VoxelOutlierRemovalSettings shares;
  shares.unit = DensityUnit::Faces;
  std::vector<Method> methods = lawMethods();
  methods.push_back(filterMethod(Law::Quadratic, "", shares));
  methods.push_back(filterWithoutHistory(shares));
  methods.push_back(filterMethod(Law::Count));
  methods.push_back(sensorsAloneMethod(stream));
  return methods;
}

std::vector<Method>
lidarMethods()
{
  return {lawMethod(Law::Native, {5, 10, 20, 30, 40, 50, 60, 80}),
          lawMethod(Law::Count, {2, 3, 4, 5, 7, 10}),
          filterMethod(Law::Count),
          filterOnVoxels()};
}

std::vector<Method>
peerMethods(double resolution)
{
  std::vector<Method> methods;
  for (const int neighbours : {4, 8, 16, 26, 50})
    methods.push_back(
        {"StatisticalOutlierRemoval " + std::to_string(neighbours) + " neighbours",
         [neighbours](const LabelledFrame& frame, std::vector<float>& scores) {
           statisticalScores(centresOf(frame.of(Law::Count)), neighbours, scores);
         },
         {},
         {}});
  // Between the distances to which voxels' centres can be apart.
  for (const double voxels : {1.2, 1.5, 1.8, 2.1, 2.5, 3.1, 4.1})
    methods.push_back(
        {"RadiusOutlierRemoval " + measuring::formatted(voxels, 1) + " voxels",
         [voxels, resolution](const LabelledFrame& frame, std::vector<float>& scores) {
           radiusScores(centresOf(frame.of(Law::Count)), voxels * resolution, scores);
         },
         {},
         {}});
  methods.push_back(filterMethod(Law::Quadratic));
  return methods;
}

void
judge(const LabelledFrame& frame, std::vector<Method>& methods)
{
  std::vector<float> scores;
  for (Method& method : methods) {
    method.score(frame, scores);
    method.voxels.add(frame, scores);
  }
}

} // namespace noise
} // namespace pcl_ext
