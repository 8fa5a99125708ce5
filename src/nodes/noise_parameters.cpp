// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/impl/node_parameters.h>

#include "nodes/parameter_access.h"

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

std::vector<ParameterDescription>
describeNoiseParameters()
{
  const VoxelOutlierRemovalSettings removal;
  return {
      // Any sign, as native intensities can be negative.
      numberParameter("min_intensity",
                      "of the intensity",
                      NoiseSettings().min_intensity,
                      -largest_float_value,
                      largest_float_value,
                      "Voxels of lower intensity are noise and are removed; 0: none "
                      "are; no effect on streams without intensities."),
      flagParameter(
          "remove_outliers",
          false,
          "Remove voxels that are noise, judged by their surroundings in this "
          "frame and the last ones of the stream."),
      numberParameter("min_log_odds",
                      "",
                      removal.min_log_odds,
                      -largest_float_value,
                      largest_float_value,
                      "Log-odds of surface against noise, natural logarithm; voxels of "
                      "lower ones are outliers."),
      wordParameter("density_unit",
                    nameOf(density_units, densityUnitOf(removal.unit)),
                    density_units,
                    "What outliers are judged by: faces for the quadratic law, points "
                    "for counts of depth cameras, rays for snow in clouds of lidars "
                    "that are at the origin of their frame or have rows and columns, "
                    "voxels for other noise of lidars."),
      flagParameter("packed",
                    false,
                    "Write points without gaps, and not in the layout of the messages "
                    "that were compressed.")};
}

} // namespace

const std::vector<ParameterDescription>&
noiseParameters()
{
  static const std::vector<ParameterDescription> parameters = describeNoiseParameters();
  return parameters;
}

float
NoiseSettings::lowestIntensity() const
{
  return min_intensity == 0.0f ? CentralNode::lowest_intensity : min_intensity;
}

NoiseSettings
readNoiseParameters(const ParameterValues& values)
{
  const ParameterAccess access(noiseParameters(), values);
  NoiseSettings settings;
  settings.min_intensity = access.number("min_intensity");
  settings.is_packed = access.get<bool>("packed");
  if (access.get<bool>("remove_outliers"))
    settings.outlier_removal = VoxelOutlierRemovalSettings{
        densityUnitSettings(access.named("density_unit", density_units)),
        access.number("min_log_odds")};
  return settings;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
