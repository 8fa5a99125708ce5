// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "options/decoding_options.h"

#include "console/exit_status.h"
#include "options/encoding_options.h"
#include "options/options.h"
#include "options/text_values.h"

#include <algorithm>
#include <memory>

namespace pcl_ext::tools {

void
addLimits(CLI::App& app, io::DecoderLimits& limits)
{
  constexpr std::size_t most = io::DecoderLimits::most_voxels;
  limits = io::DecoderLimits::ofBudget(std::make_shared<io::MemoryBudget>());
  app.add_option_function<std::size_t>(
         "--max-voxels",
         [&limits](std::size_t voxels) {
           limits.max_voxels = voxels;
           limits.free_voxels = most;
         },
         "refuse frames with more voxels or points (2^28, above 2^23 only those with "
         "a byte for 64 of them)")
      ->check([](const std::string& text) {
        return refuseOutside(text, std::size_t{1}, most);
      })
      ->type_name("N");
  addParsed(app,
            "--memory-limit",
            "SIZE",
            "for what decoders keep from frame to frame, such as 2GB (a quarter "
            "of the machine's)",
            [&limits](const std::string& text) {
              limits.budget =
                  std::make_shared<io::MemoryBudget>(static_cast<std::size_t>(
                      std::max(1.0, parseBytes("--memory-limit", text))));
            });
}

void
addDecodingOptions(CLI::App& app, DecodingOptions& options)
{
  app.add_option("--min-intensity", options.min_intensity, "leave out voxels with less")
      ->check(refuseNan)
      ->type_name("I");
  addOutlierRemoval(app,
                    "leave out noise, as VoxelOutlierRemoval finds it",
                    options.removes_outliers,
                    "for --remove-outliers; name rays for a lidar",
                    options.unit);
  addParsed(
      app,
      "--sensor-position",
      "X,Y,Z",
      "of a lidar, metres, for --unit rays (that of the recorded pose, else 0,0,0)",
      [&options](const std::string& text) {
        // CLI11 reads options in the order in which they are added: the unit is known.
        if (options.unit != DensityUnit::Rays)
          throw UsageError("--sensor-position has no effect without --unit rays: add "
                           "it, or leave this one out");
        options.sensor_position = parsePosition("sensor-position", text);
      });
  addLimits(app, options.limits);
}

} // namespace pcl_ext::tools
