#include "scan_results.h"

#include "measuring/machine.h"
#include "measuring/result_file.h"
#include "method_results.h"
#include "scan_voxels.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace noise {

namespace {

ScoredVoxels
scoredByRange()
{
  return ScoredVoxels({range_band_ends.begin(), range_band_ends.end()});
}

/** \brief Scores of the judged parts among those of all.
 * \param[in] scores of all points or voxels
 */
void
addJudged(const JudgedParts& judged,
          const std::vector<float>& scores,
          const std::string& method,
          ScoredVoxels& scored)
{
  std::vector<float> of_judged;
  for (const std::size_t i : judged.indices) {
    of_judged.push_back(scores.at(i));
    if (std::isnan(of_judged.back()))
      throw std::logic_error("the method '" + method + "' has a score that is NaN");
  }
  scored.add(judged.truth, judged.range, of_judged);
}

/** \brief Calls a function and notes the processor time that it takes. */
template <typename CallT>
void
timed(std::vector<double>& milliseconds, const CallT& call)
{
  const double start = measuring::processCpuSeconds();
  call();
  milliseconds.push_back(1e3 * (measuring::processCpuSeconds() - start));
}

/** \brief Writes the results of one method. */
class MethodOutput {
public:
  MethodOutput(const ScanRange& range,
               const ScanMethod& method,
               measuring::ResultFile& results)
  : range_(range), method_(method), results_(results)
  {}

  /** \param[in] resolution voxel edge, metres; 0 where there is none */
  void
  add(const std::string& unit, double resolution, ScoredVoxels scored)
  {
    Measured measured{"scan_" + unit, range_.sensor, resolution, range_.count};
    measured.unit = unit;
    Method judged{method_.name, {}, method_.thresholds, std::move(scored)};
    if (method_.is_decision)
      addDecisions(measured, std::move(judged), results_);
    else
      addResults(measured, {std::move(judged)}, results_);
  }

  void
  addTimes(double resolution, double points, std::vector<double> milliseconds)
  {
    std::sort(milliseconds.begin(), milliseconds.end());
    const measuring::Subject subject{
        "scan_time", range_.sensor, method_.name, resolution};
    results_.add(subject, "points", points, range_.count);
    results_.add(
        subject, "median_ms", milliseconds[milliseconds.size() / 2], range_.count);
    results_.add(subject, "longest_ms", milliseconds.back(), range_.count);
  }

private:
  const ScanRange& range_;
  const ScanMethod& method_;
  measuring::ResultFile& results_;
};

double
meanPoints(const LabelledScan& scan, const ScanRange& range)
{
  return static_cast<double>(scan.returns->size()) / static_cast<double>(range.count);
}

void
judgePointScores(LabelledScans& scans,
                 const ScanRange& range,
                 const ScanMethod& method,
                 MethodOutput& output)
{
  std::vector<ScanVoxelizer> voxelizers(range.resolutions.begin(),
                                        range.resolutions.end());
  std::vector<ScoredVoxels> of_voxels(voxelizers.size(), scoredByRange());
  ScoredVoxels of_points = scoredByRange();
  std::vector<double> milliseconds;
  double points = 0.0;
  LabelledScan scan;
  VoxelizedScan voxels;
  std::vector<float> scores;
  std::vector<float> voxel_scores;
  for (std::size_t i = 0; i < range.count; ++i) {
    scans.read(range.first + i, scan);
    points += meanPoints(scan, range);
    timed(milliseconds, [&] { method.score_points(scan, scores); });
    addJudged(judgedPoints(scan), scores, method.name, of_points);
    for (std::size_t k = 0; k < voxelizers.size(); ++k) {
      voxelizers[k].voxelize(scan, voxels);
      highestScores(scan, voxels, scores, voxel_scores);
      addJudged(voxels.judged, voxel_scores, method.name, of_voxels[k]);
    }
  }
  output.add("points", 0.0, std::move(of_points));
  for (std::size_t k = 0; k < of_voxels.size(); ++k)
    output.add("voxels", range.resolutions[k], std::move(of_voxels[k]));
  output.addTimes(0.0, points, std::move(milliseconds));
}

void
judgeVoxelScores(LabelledScans& scans,
                 const ScanRange& range,
                 double resolution,
                 const ScanMethod& method,
                 MethodOutput& output)
{
  ScanVoxelizer voxelizer(resolution);
  const Method::Score score = method.voxel_score(resolution);
  ScoredVoxels of_voxels = scoredByRange();
  ScoredVoxels of_points = scoredByRange();
  std::vector<double> milliseconds;
  double points = 0.0;
  LabelledScan scan;
  VoxelizedScan voxels;
  std::vector<float> scores;
  for (std::size_t i = 0; i < range.count; ++i) {
    scans.read(range.first + i, scan);
    points += meanPoints(scan, range);
    voxelizer.voxelize(scan, voxels);
    timed(milliseconds, [&] { score(voxels.frame, scores); });
    addJudged(voxels.judged, scores, method.name, of_voxels);
    std::vector<float> point_scores(scan.cloud.size(), 0.0f);
    for (std::size_t k = 0; k < voxels.voxel_of_return.size(); ++k)
      point_scores[scan.index_of_return[k]] = scores.at(voxels.voxel_of_return[k]);
    addJudged(judgedPoints(scan), point_scores, method.name, of_points);
  }
  output.add("points", resolution, std::move(of_points));
  output.add("voxels", resolution, std::move(of_voxels));
  output.addTimes(resolution, points, std::move(milliseconds));
}

} // namespace

void
judgeScans(LabelledScans& scans,
           const ScanRange& range,
           const ScanMethod& method,
           measuring::ResultFile& results)
{
  if (range.count == 0 || range.first + range.count > scans.size())
    throw std::runtime_error("there are no scans " + std::to_string(range.first) +
                             " to " + std::to_string(range.first + range.count) +
                             ": there are " + std::to_string(scans.size()));
  MethodOutput output(range, method, results);
  if (method.score_points) {
    judgePointScores(scans, range, method, output);
    return;
  }
  for (const double resolution : range.resolutions)
    judgeVoxelScores(scans, range, resolution, method, output);
}

} // namespace noise
} // namespace pcl_ext
