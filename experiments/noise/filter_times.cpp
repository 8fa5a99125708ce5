#include "filter_times.h"

#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "measuring/machine.h"
#include "measuring/markdown_table.h"
#include "measuring/result_file.h"
#include "point_filters.h"
#include "simulator/labelled_stream.h"

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace noise {

namespace {

/** \brief A filter, and its processor seconds for a frame. */
struct TimedFilter {
  std::string name;
  std::function<double(const LabelledFrame&, const Centres::Ptr&)> seconds;
  std::vector<double> milliseconds; ///< of each frame
};

TimedFilter
voxelFilter(Law law, VoxelOutlierRemoval& removal)
{
  return {"VoxelOutlierRemoval on " + nameOf(law),
          [law, &removal](const LabelledFrame& frame, const Centres::Ptr&) {
            io::VoxelFrame filtered = frame.of(law);
            const double start = measuring::processCpuSeconds();
            static_cast<void>(removal.filter(filtered));
            return measuring::processCpuSeconds() - start;
          },
          {}};
}

TimedFilter
statisticalFilter(int neighbours)
{
  return {"StatisticalOutlierRemoval " + std::to_string(neighbours) + " neighbours",
          [neighbours](const LabelledFrame&, const Centres::Ptr& centres) {
            return statisticalSeconds(centres, neighbours);
          },
          {}};
}

TimedFilter
radiusFilter(double voxels, double resolution)
{
  return {"RadiusOutlierRemoval " + measuring::formatted(voxels, 1) + " voxels",
          [radius = voxels * resolution](const LabelledFrame&,
                                         const Centres::Ptr& centres) {
            return radiusSeconds(centres, radius);
          },
          {}};
}

} // namespace

void
measureFilterTimes(std::uint32_t seed,
                   unsigned int sensor,
                   std::uint32_t frames,
                   double resolution,
                   measuring::ResultFile& results)
{
  LabelledStream stream(seed, sensor, resolution);
  VoxelOutlierRemoval on_quadratic;
  VoxelOutlierRemovalSettings counts;
  counts.unit = densityUnitOf(Law::Count);
  VoxelOutlierRemoval on_count(counts);
  std::vector<TimedFilter> filters = {voxelFilter(Law::Quadratic, on_quadratic),
                                      voxelFilter(Law::Count, on_count),
                                      statisticalFilter(8),
                                      statisticalFilter(26),
                                      radiusFilter(1.8, resolution),
                                      radiusFilter(2.5, resolution)};
  double voxels = 0.0;
  LabelledFrame frame;
  for (std::uint32_t i = 0; i < frames; ++i) {
    stream.read(i, frame);
    voxels += static_cast<double>(frame.truth.size()) / frames;
    const Centres::Ptr centres = centresOf(frame.of(Law::Count));
    for (TimedFilter& filter : filters)
      filter.milliseconds.push_back(1e3 * filter.seconds(frame, centres));
  }
  for (TimedFilter& filter : filters) {
    std::vector<double>& times = filter.milliseconds;
    std::sort(times.begin(), times.end());
    const measuring::Subject subject{
        "noise_time", std::to_string(sensor), filter.name, resolution};
    results.add(subject, "voxels", voxels, frames);
    results.add(subject, "median_ms", times[times.size() / 2], frames);
    results.add(subject, "longest_ms", times.back(), frames);
  }
}

} // namespace noise
} // namespace pcl_ext
