#include "filter_times.h"

#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "measuring/machine.h"
#include "measuring/markdown_table.h"
#include "point_filters.h"
#include "simulator/labelled_stream.h"

#include <result_file.h>

#include <algorithm>
#include <functional>
#include <ostream>

namespace pcl_ext {
namespace noise {

namespace {

/** \brief What one of the filters does with a frame; processor seconds. */
using TimeOfFrame = std::function<double(const LabelledFrame&, const Centres::Ptr&)>;

struct TimedFilter {
  std::string name;
  TimeOfFrame seconds;
};

TimedFilter
voxelFilter(Law law, VoxelOutlierRemoval& removal)
{
  return {"VoxelOutlierRemoval on " + nameOf(law),
          [law, &removal](const LabelledFrame& frame, const Centres::Ptr&) {
            io::VoxelFrame filtered = frame.of(law);
            const double start = measuring::processCpuSeconds();
            removal.filter(filtered);
            return measuring::processCpuSeconds() - start;
          }};
}

TimedFilter
statisticalFilter(int neighbours)
{
  return {"StatisticalOutlierRemoval " + std::to_string(neighbours) + " neighbours",
          [neighbours](const LabelledFrame&, const Centres::Ptr& centres) {
            return statisticalSeconds(centres, neighbours);
          }};
}

TimedFilter
radiusFilter(double voxels, double resolution)
{
  return {"RadiusOutlierRemoval " + measuring::formatted(voxels, 1) + " voxels",
          [radius = voxels * resolution](const LabelledFrame&,
                                         const Centres::Ptr& centres) {
            return radiusSeconds(centres, radius);
          }};
}

double
longestOf(const std::vector<double>& values)
{
  return *std::max_element(values.begin(), values.end());
}

} // namespace

TimedFilters
measureFilterTimes(std::uint32_t seed,
                   unsigned int sensor,
                   std::uint32_t frames,
                   double resolution)
{
  LabelledStream stream(seed, sensor, resolution);
  VoxelOutlierRemoval on_quadratic;
  VoxelOutlierRemoval on_count;
  const std::vector<TimedFilter> filters = {voxelFilter(Law::Quadratic, on_quadratic),
                                            voxelFilter(Law::Count, on_count),
                                            statisticalFilter(8),
                                            statisticalFilter(26),
                                            radiusFilter(1.8, resolution),
                                            radiusFilter(2.5, resolution)};
  TimedFilters timed{sensor, resolution, 0.0, {}};
  for (const TimedFilter& filter : filters)
    timed.filters.push_back({filter.name, {}});
  LabelledFrame frame;
  for (std::uint32_t i = 0; i < frames; ++i) {
    stream.read(i, frame);
    timed.voxels += static_cast<double>(frame.truth.size()) / frames;
    const Centres::Ptr centres = centresOf(frame.of(Law::Count));
    for (std::size_t filter = 0; filter < filters.size(); ++filter)
      timed.filters[filter].milliseconds.push_back(
          1e3 * filters[filter].seconds(frame, centres));
  }
  return timed;
}

double
medianOf(std::vector<double> values)
{
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void
print(const TimedFilters& timed, std::ostream& output)
{
  measuring::MarkdownTable table({"filter", "median", "longest"});
  for (const FilterTimes& times : timed.filters)
    table.addRow({times.filter,
                  measuring::formatted(medianOf(times.milliseconds), 2),
                  measuring::formatted(longestOf(times.milliseconds), 2)});
  table.print(output);
}

void
addResults(const TimedFilters& timed, report::ResultFile& results)
{
  for (const FilterTimes& times : timed.filters) {
    const report::Subject subject{
        "noise_time", std::to_string(timed.sensor), times.filter, timed.resolution};
    const std::size_t frames = times.milliseconds.size();
    results.add(subject, "voxels", timed.voxels, frames);
    results.add(subject, "median_ms", medianOf(times.milliseconds), frames);
    results.add(subject, "longest_ms", longestOf(times.milliseconds), frames);
  }
}

} // namespace noise
} // namespace pcl_ext
