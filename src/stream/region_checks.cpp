#include "stream/region_checks.h"

#include <pcl_ext/compression/voxel_regions.h>

#include "stream/setting_checks.h"

#include <algorithm>
#include <string>

namespace pcl_ext {
namespace io {

namespace {

template <typename ValueT>
CompressionStatus
invalid(const std::string& field, const ValueT& value, const std::string& demand)
{
  return {CompressionCode::InvalidSettings, invalidMessage(field, value, demand)};
}

CompressionStatus
checkRegion(const Region& region, const std::string& name, double resolution)
{
  if (const std::string fault = boxFault(name, region.box); !fault.empty())
    return {CompressionCode::InvalidSettings, fault};
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (const double width = region.box.max[axis] - region.box.min[axis];
        width < resolution)
      return invalid(name,
                     std::to_string(width) + " m wide",
                     "at least as wide as the resolution on each axis");
  if (region.doublings > most_region_levels)
    return invalid(name + ": doublings", region.doublings, "0 to 5");
  if (region.frame != RegionFrame::World && region.frame != RegionFrame::Sensor)
    return invalid(name + ": frame", static_cast<int>(region.frame), "World or Sensor");
  return {};
}

CompressionStatus
checkDistance(const RegionSettings& regions, double resolution)
{
  if (regions.coarser_beyond == 0.0)
    return {};
  // Comparisons with NaN are false.
  if (!(regions.coarser_beyond >= resolution &&
        regions.coarser_beyond <= farthest_region * resolution))
    return invalid("coarser_beyond",
                   regions.coarser_beyond,
                   "0 for off, or metres from the resolution to 2^22 times it");
  if (regions.most_doublings < 1 || regions.most_doublings > most_region_levels)
    return invalid("most_doublings", regions.most_doublings, "1 to 5");
  return {};
}

} // namespace

CompressionStatus
checkRegions(const EncoderSettings& settings)
{
  const RegionSettings& regions = settings.regions;
  if (regions.outside != OutsideRegions::Coarsest &&
      regions.outside != OutsideRegions::LeftOut)
    return invalid(
        "outside of regions", static_cast<int>(regions.outside), "Coarsest or LeftOut");
  const bool leaves_out = regions.outside == OutsideRegions::LeftOut;
  if (leaves_out && regions.boxes.empty())
    return invalid("outside of regions", "left-out", "coarsest without a region");
  if (leaves_out && regions.coarser_beyond != 0.0)
    return invalid("outside of regions", "left-out", "coarsest with coarser_beyond");
  if (!regions.areAny())
    return {};
  if (settings.format == StreamFormat::Published)
    return invalid("regions", "set", "empty in the published layout");
  if (settings.keep_point_counts)
    return invalid("keep_point_counts", "on", "off with regions");
  if (!settings.fields.empty())
    return invalid("fields", "set", "empty with regions");
  if (regions.boxes.size() > most_regions)
    return invalid("number of regions", regions.boxes.size(), "64 at most");
  for (std::size_t i = 0; i < regions.boxes.size(); ++i)
    if (CompressionStatus status = checkRegion(
            regions.boxes[i], "region " + std::to_string(i + 1), settings.resolution);
        !status.ok())
      return status;
  return checkDistance(regions, settings.resolution);
}

} // namespace io
} // namespace pcl_ext
