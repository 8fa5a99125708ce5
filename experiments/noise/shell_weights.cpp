#include "shell_weights.h"

#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "measuring/result_file.h"
#include "methods.h"
#include "simulator/labelled_lidar.h"
#include "simulator/labelled_stream.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <unordered_map>
#include <vector>

namespace pcl_ext {
namespace noise {

namespace {

/** \brief 1 and the logarithms of core, ring and rim; and whether it is a surface. */
struct Sample {
  Eigen::Vector4d features;
  double is_surface;
};

std::uint64_t
keyAt(std::uint32_t x, std::uint32_t y, std::uint32_t z)
{
  return std::uint64_t{x} << 42 | std::uint64_t{y} << 21 | z;
}

/** \brief f of the header of VoxelOutlierRemoval, in real numbers. */
class Field {
public:
  void
  add(const LabelledFrame& labelled, double cut_off_depth)
  {
    const double edge = labelled.of(Law::Quadratic).grid.resolution;
    const double enough_points =
        std::max(1.0, VoxelOutlierRemoval::sure_points_per_square_metre * edge * edge);
    const io::VoxelFrame& frame = labelled.of(Law::Quadratic);
    for (auto it = cells_.begin(); it != cells_.end();) {
      it->second.mean *= 0.75;
      it->second.f = it->second.mean / 2.0;
      it = it->second.mean < 1e-3 ? cells_.erase(it) : std::next(it);
    }
    for (std::size_t i = 0; i < frame.size(); ++i) {
      const io::VoxelPosition at = io::voxelPosition(frame.keys[i]);
      Cell& cell = cells_[keyAt(at.x + 2, at.y + 2, at.z + 2)];
      const double points_on_face =
          std::pow(cut_off_depth / static_cast<double>(labelled.depth[i]), 2);
      const double density = std::min(
          1.0,
          frame.intensities[i] / 255.0 * std::max(1.0, points_on_face / enough_points));
      cell.mean += density / 4.0;
      cell.f = density;
    }
  }

  Eigen::Vector4d
  featuresAt(const io::VoxelPosition& at) const
  {
    std::array<double, 3> shells{};
    for (std::uint32_t x = 0; x < 5; ++x)
      for (std::uint32_t y = 0; y < 5; ++y)
        for (std::uint32_t z = 0; z < 5; ++z) {
          const auto found = cells_.find(keyAt(at.x + x, at.y + y, at.z + z));
          if (found == cells_.end())
            continue;
          const std::uint32_t steps = distance(x) + distance(y) + distance(z);
          const bool is_rim = std::max({distance(x), distance(y), distance(z)}) == 2;
          shells[steps < 2 ? 0
                 : is_rim  ? 2
                           : 1] += (steps == 0 ? 2.0 : 1.0) * found->second.f;
        }
    return {1.0,
            std::log(shells[0] + 0.02),
            std::log(shells[1] + 0.02),
            std::log(shells[2] + 0.02)};
  }

private:
  struct Cell {
    double mean = 0.0;
    double f = 0.0;
  };

  static std::uint32_t
  distance(std::uint32_t offset)
  {
    return offset < 2 ? 2 - offset : offset - 2;
  }

  std::unordered_map<std::uint64_t, Cell> cells_;
};

/** \brief Maximum likelihood by Newton's method. */
Eigen::Vector4d
fit(const std::vector<Sample>& samples)
{
  Eigen::Vector4d weights = Eigen::Vector4d::Zero();
  for (int step = 0; step < 20; ++step) {
    Eigen::Vector4d gradient = Eigen::Vector4d::Zero();
    Eigen::Matrix4d curvature = 1e-6 * Eigen::Matrix4d::Identity();
    for (const Sample& sample : samples) {
      const double probability = 1.0 / (1.0 + std::exp(-weights.dot(sample.features)));
      gradient += (sample.is_surface - probability) * sample.features;
      curvature += probability * (1.0 - probability) * sample.features *
                   sample.features.transpose();
    }
    weights += curvature.ldlt().solve(gradient);
  }
  return weights;
}

} // namespace

void
fitShellWeights(std::uint32_t seed,
                unsigned int sensor,
                std::uint32_t frames,
                double resolution,
                measuring::ResultFile& results)
{
  LabelledStream stream(seed, sensor, resolution);
  LabelledFrame frame;
  Field field;
  const double cut_off_depth =
      IntensityModel<KinectV2, QuadraticLaw>(resolution).cutOffDepth();
  std::vector<Sample> samples;
  for (std::uint32_t i = 0; i < frames; ++i) {
    stream.read(i, frame);
    const io::VoxelFrame& voxels = frame.of(Law::Quadratic);
    field.add(frame, cut_off_depth);
    if (i % 10 != 9)
      continue;
    for (std::size_t voxel = 0; voxel < voxels.size(); ++voxel)
      samples.push_back({field.featuresAt(io::voxelPosition(voxels.keys[voxel])),
                         frame.truth[voxel] == VoxelTruth::Noise ? 0.0 : 1.0});
  }
  const Eigen::Vector4d weights = fit(samples);
  const measuring::Subject subject{
      "noise_weights", std::to_string(sensor), "logistic regression", resolution};
  const std::array<const char*, 4> names = {"c", "core", "ring", "rim"};
  for (std::size_t i = 0; i < names.size(); ++i)
    results.add(subject, names[i], weights[static_cast<Eigen::Index>(i)], frames);
}

void
fitVoxelsOffset(std::uint32_t seed,
                std::uint32_t frames,
                double resolution,
                measuring::ResultFile& results)
{
  LabelledLidar stream(seed, resolution);
  LabelledFrame frame;
  VoxelOutlierRemovalSettings settings;
  settings.unit = DensityUnit::Voxels;
  VoxelOutlierRemoval removal(settings);
  std::vector<double> log_odds;
  double surfaces = 0.0;
  std::vector<float> scores;
  for (std::uint32_t i = 0; i < frames; ++i) {
    stream.read(i, frame);
    removal.score(frame.of(Law::Count), scores);
    for (std::size_t voxel = 0; voxel < scores.size(); ++voxel) {
      log_odds.push_back(static_cast<double>(scores[voxel]));
      surfaces += frame.truth[voxel] == VoxelTruth::Noise ? 0.0 : 1.0;
    }
  }
  // The maximum likelihood: as many surfaces are expected as there are.
  double offset = 0.0;
  for (int step = 0; step < 50; ++step) {
    double expected = 0.0;
    double slope = 0.0;
    for (const double score : log_odds) {
      const double probability = 1.0 / (1.0 + std::exp(-score - offset));
      expected += probability;
      slope += probability * (1.0 - probability);
    }
    offset += std::clamp((surfaces - expected) / slope, -1.0, 1.0);
  }
  results.add({"noise_weights", "7", "unit Voxels", resolution},
              "missing in c",
              offset,
              frames);
}

} // namespace noise
} // namespace pcl_ext
