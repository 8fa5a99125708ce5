#include "table_cells.h"

#include "measuring/markdown_table.h"
#include "pcl_compression.h"

#include <algorithm>

namespace pcl_ext {
namespace measuring {

namespace {

const CoderFigures&
figuresOf(const Comparison& comparison, const std::string& name)
{
  return *std::find_if(comparison.coders.begin(),
                       comparison.coders.end(),
                       [&name](const CoderFigures& f) { return f.name == name; });
}

} // namespace

Workload
workloadAt(double resolution, unsigned int i_frame_rate, IntensityLaw law)
{
  Workload workload;
  workload.law = law;
  workload.resolution = resolution;
  workload.i_frame_rate = i_frame_rate;
  return workload;
}

std::string
medianAndMean(const Samples& samples)
{
  return formatted(samples.median(), 2) + " (" + formatted(samples.mean(), 2) + ")";
}

std::string
factor(double faster)
{
  return formatted(faster, faster < 1.0 ? 2 : 1) + "x";
}

std::string
timeAgainst(const Samples& samples, const Samples& reference)
{
  return formatted(samples.median(), 2) + " (" +
         factor(reference.median() / samples.median()) + ")";
}

std::string
signedPercent(double percent)
{
  return (percent > 0.0 ? "+" : "") + formatted(percent, 1) + " %";
}

std::string
againstPublished(const CoderFigures& coder, const Comparison& comparison)
{
  if (coder.content != Content::VoxelsWithIntensity)
    return {};
  const CoderFigures& published =
      figuresOf(comparison, coderName(libraryVariants().back()));
  return signedPercent(100.0 * (coder.bytes.sum() / published.bytes.sum() - 1.0));
}

const CoderFigures&
pclOf(const Comparison& comparison)
{
  return figuresOf(comparison, pcl_voxel_grid_name);
}

} // namespace measuring
} // namespace pcl_ext
