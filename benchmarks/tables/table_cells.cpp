// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "tables/table_cells.h"

#include "coders/pcl_compression.h"
#include "measuring/markdown_table.h"

#include <algorithm>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief Null if the coder is not compared. */
const CoderFigures*
figuresOf(const Comparison& comparison, const std::string& name)
{
  const auto found =
      std::find_if(comparison.coders.begin(),
                   comparison.coders.end(),
                   [&name](const auto& coder) { return coder.name == name; });
  return found == comparison.coders.end() ? nullptr : &*found;
}

} // namespace

Workload
workloadAt(double resolution, IntensityLaw law)
{
  Workload workload;
  workload.law = law;
  workload.resolution = resolution;
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
  const CoderFigures* const published =
      figuresOf(comparison, coderName(libraryVariants().back()));
  if (coder.content != Content::VoxelsWithIntensity || published == nullptr)
    return {};
  return signedPercent(100.0 * (coder.bytes.sum() / published->bytes.sum() - 1.0));
}

const CoderFigures&
pclOf(const Comparison& comparison)
{
  return *figuresOf(comparison, pcl_voxel_grid_name);
}

} // namespace measuring
} // namespace pcl_ext
