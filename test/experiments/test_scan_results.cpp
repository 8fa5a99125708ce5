#include "measuring/result_file.h"
#include "noise/scan_results.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::noise;

struct ScoredPoint {
  float x; ///< range, metres; 0: no return
  PointClass point_class;
  float score; ///< as its intensity
};

/** \brief Scans of points that carry the score that a method gives them. */
class ScriptedScans : public LabelledScans {
public:
  explicit ScriptedScans(std::vector<std::vector<ScoredPoint>> scans)
  : scans_(std::move(scans))
  {}

  std::size_t
  size() const override
  {
    return scans_.size();
  }

  void
  read(std::size_t index, LabelledScan& scan) override
  {
    scan.name = std::to_string(index);
    scan.cloud.clear();
    scan.classes.clear();
    for (const ScoredPoint& point : scans_.at(index)) {
      pcl::PointXYZI at;
      at.x = point.x;
      at.y = at.z = 0.0f;
      at.intensity = point.score;
      scan.cloud.push_back(at);
      scan.classes.push_back(point.point_class);
    }
    scan.collectReturns();
  }

private:
  std::vector<std::vector<ScoredPoint>> scans_;
};

/** \brief Scan 0 is not judged in the tests, 1 and 2 are. */
ScriptedScans
threeScans()
{
  return ScriptedScans({{{5.05f, PointClass::Surface, 0.0f}},
                        {{5.02f, PointClass::Noise, 1.0f},
                         {5.07f, PointClass::Noise, 4.0f}, // in the voxel of the last
                         {8.05f, PointClass::Ignored, 0.0f},
                         {9.05f, PointClass::Surface, 2.0f},
                         {15.05f, PointClass::Person, 5.0f}},
                        {{0.0f, PointClass::Missing, 0.0f},
                         {15.05f, PointClass::Noise, 3.0f},
                         {25.05f, PointClass::Pole, 6.0f},
                         {50.05f, PointClass::Surface, 1.5f}}});
}

ScanRange
lastTwo()
{
  return {"scripted", 1, 2, {0.1}};
}

/** \brief Results by `experiment,method,edge in cm,quantity`. */
std::map<std::string, double>
resultsOf(ScriptedScans scans, const ScanRange& range, const ScanMethod& method)
{
  const recording::test::TestFolder folder;
  const std::string path = folder / "results.csv";
  {
    measuring::ResultFile results(path);
    judgeScans(scans, range, method, results);
    results.close();
  }
  std::map<std::string, double> values;
  std::ifstream file(path);
  std::string line;
  std::getline(file, line); // names of the columns
  while (std::getline(file, line)) {
    std::array<std::string, 8> words;
    std::istringstream columns(line);
    for (std::string& word : words)
      std::getline(columns, word, ',');
    values[words[0] + ',' + words[2] + ',' + words[3] + ',' + words[4]] =
        std::stod(words[5]);
  }
  return values;
}

ScanMethod
scriptedMethod()
{
  return pointMethod("scripted",
                     [](const LabelledScan& scan, std::vector<float>& scores) {
                       scores.clear();
                       for (const pcl::PointXYZI& point : scan.cloud)
                         scores.push_back(point.intensity);
                     },
                     {3.5f});
}

TEST(ScanResults, PointsByRange)
{
  const auto results = resultsOf(threeScans(), lastTwo(), scriptedMethod());
  const auto of = [&](const std::string& key) { return results.at(key); };
  // By their scores: noise 1, surface 1.5, surface 2, noise 3, noise 4, person, pole.
  EXPECT_NEAR(of("scan_points,scripted,0,noise_percent"), 300.0 / 7.0, 1e-6);
  EXPECT_NEAR(of("scan_points,scripted,0,average_precision"),
              (1.0 + 2.0 / 4.0 + 3.0 / 5.0) / 3.0,
              1e-6);
  EXPECT_NEAR(of("scan_points_threshold:3.5,scripted,0,recall"), 2.0 / 3.0, 1e-6);
  EXPECT_NEAR(of("scan_points_threshold:3.5,scripted,0,precision"), 0.5, 1e-6);
  EXPECT_NEAR(
      of("scan_points_threshold:3.5,scripted,0,pole_kept_percent"), 100.0, 1e-6);
  const std::string near = "scan_points_band:up to 10 m,scripted,0,";
  EXPECT_EQ(of(near + "noise_points"), 1.0); // of a scan
  EXPECT_EQ(of(near + "surface_points"), 0.5);
  EXPECT_NEAR(of(near + "average_precision"), (1.0 + 2.0 / 3.0) / 2.0, 1e-6);
  const std::string middle = "scan_points_band:10 to 20 m,scripted,0,";
  EXPECT_EQ(of(middle + "noise_points"), 0.5);
  EXPECT_EQ(of(middle + "average_precision"), 1.0);
  EXPECT_EQ(of("scan_points_band:20 to 40 m,scripted,0,surface_points"), 0.5);
  EXPECT_EQ(of("scan_points_band:40 m and more,scripted,0,surface_points"), 0.5);
  // Of two scans the points with a return, also those that are not judged.
  EXPECT_EQ(of("scan_time,scripted,0,points"), 4.0);
}

TEST(ScanResults, VoxelsHaveTheHighestScoreOfTheirPoints)
{
  const auto results = resultsOf(threeScans(), lastTwo(), scriptedMethod());
  // Surface 1.5, surface 2, noise 3, noise 4 (of two points), person 5, pole 6.
  EXPECT_NEAR(results.at("scan_voxels,scripted,10,average_precision"),
              (1.0 / 3.0 + 2.0 / 4.0) / 2.0,
              1e-6);
  EXPECT_EQ(results.at("scan_voxels_band:up to 10 m,scripted,10,noise_voxels"), 0.5);
  EXPECT_EQ(results.at("scan_voxels_band:up to 10 m,scripted,10,surface_voxels"), 0.5);
}

TEST(ScanResults, ScoresOfVoxelsAreThoseOfTheirPoints)
{
  // A voxel's score is its place, so that nearer ones are noise.
  std::vector<double> edges;
  const ScanMethod method = voxelMethod("by place", [&](double resolution) {
    edges.push_back(resolution);
    return [](const LabelledFrame& frame, std::vector<float>& scores) {
      scores = frame.depth;
    };
  });
  const auto results = resultsOf(threeScans(), lastTwo(), method);
  EXPECT_EQ(edges, std::vector<double>{0.1});
  // Points: two of noise at 5 m, a surface at 9 m, noise and a person at 15 m.
  EXPECT_NEAR(results.at("scan_points,by place,10,average_precision"),
              (2.0 * 1.0 + 3.0 / 5.0) / 3.0,
              1e-6);
  EXPECT_NEAR(results.at("scan_voxels,by place,10,average_precision"),
              (1.0 + 2.0 / 4.0) / 2.0,
              1e-6);
}

TEST(ScanResults, DecisionsHaveNoCurve)
{
  ScanMethod method = scriptedMethod();
  method.is_decision = true;
  const auto results = resultsOf(threeScans(), lastTwo(), method);
  EXPECT_NEAR(results.at("scan_points,scripted,0,given_recall"), 2.0 / 3.0, 1e-6);
  EXPECT_NEAR(results.at("scan_points,scripted,0,given_precision"), 0.5, 1e-6);
  EXPECT_EQ(results.count("scan_points,scripted,0,average_precision"), 0u);
}

TEST(ScanResults, MethodsAndRangesThatCannotBe)
{
  EXPECT_THROW(resultsOf(threeScans(), {"scripted", 2, 2, {0.1}}, scriptedMethod()),
               std::runtime_error);
  EXPECT_THROW(resultsOf(threeScans(), {"scripted", 0, 0, {0.1}}, scriptedMethod()),
               std::runtime_error);
  const ScanMethod undefined =
      pointMethod("nan", [](const LabelledScan& scan, std::vector<float>& scores) {
        scores.assign(scan.cloud.size(), std::numeric_limits<float>::quiet_NaN());
      });
  EXPECT_THROW(resultsOf(threeScans(), lastTwo(), undefined), std::logic_error);
}

} // namespace
