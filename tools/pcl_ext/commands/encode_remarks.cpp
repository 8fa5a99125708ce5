// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "commands/encode_remarks.h"

#include "options/text_values.h"

namespace pcl_ext::tools {

bool
remarkOnStream(Console& console,
               const std::string& name,
               const EncodedStreamReport& report)
{
  const EncodedSums& sums = report.sums;
  if (sums.points_outside_grid > 0)
    console.error(describePointsOutsideGrid(sums));
  if (sums.warnings > 0 && sums.first_warning != sums.first_without_them)
    console.remark(
        sums.first_warning +
        (sums.warnings > 1
             ? " (and " + counted(sums.warnings - 1, "more frame") + " with warnings)"
             : ""));
  const bool has_no_room = sums.frames == 0 && sums.clouds_left_out > 0;
  for (const auto& [kind, remark] : report.remarks)
    if (kind != Remark::Budget || !has_no_room) // else the error below has it
      console.remark(remark);
  if (2 * sums.hidden_voxels > sums.occupiedVoxels())
    console.remark(name + ": the temporal filter hid " +
                   counted(sums.hidden_voxels, "voxel") + " of " +
                   std::to_string(sums.occupiedVoxels()) +
                   ", as most are seen in few frames: take a larger --resolution, or " +
                   (report.is_filter_chosen ? "--rate-temporal-filter 0"
                                            : "leave out --temporal-filter"));
  if (has_no_room) {
    console.error(describeNoRoom(name, sums));
    return false;
  }
  for (const std::string& error : {report.frame_id_error, report.why_nothing})
    if (!error.empty())
      console.error(error);
  return report.frame_id_error.empty() && report.why_nothing.empty() &&
         sums.points_outside_grid == 0;
}

void
addViewpoints(Console& console,
              const EncodingOptions& options,
              const std::string& name,
              const Viewpoints& viewpoints,
              bool has_metadata,
              StreamMetadata& metadata)
{
  if (viewpoints.areDefault())
    return;
  if (options.hasPose(name))
    console.remark(name + ": the VIEWPOINT of the files is left out, as it does not "
                          "hold for points that --pose has moved");
  else if (!has_metadata)
    console.remark(name + ": the VIEWPOINT of the files is left out, as a .pcxi file "
                          "has no field for it; x.mcap has");
  else
    viewpoints.addTo(metadata);
}

} // namespace pcl_ext::tools
