// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "options/budget_options.h"

#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "options/options.h"
#include "options/text_values.h"

namespace pcl_ext {
namespace tools {

void
addBudgetOptions(CLI::App& app, io::RateSettings& settings)
{
  addParsed(
      app,
      "--max-rate",
      "RATE",
      "of a stream in any second, as 2Mbit/s; what follows may change",
      [&settings](const std::string& text) { settings.max_rate = parseRate(text); });
  addNumber(app,
            "--rate-buffer",
            settings.rate_buffer,
            0.01,
            1.0,
            "S",
            "seconds at --max-rate that a frame may take and wait");
  addNumber(app,
            "--max-encode-ms",
            settings.max_encode_ms,
            0.1,
            1e4,
            "MS",
            "of encoding on average; --effort follows it, too");
  addNumber(app,
            "--rate-temporal-filter",
            settings.rate_temporal_filter,
            0u,
            TemporalVoxelFilter::most_frames,
            "FRAMES",
            "strongest that may be chosen, of a sensor at rest");
  addNumber(app,
            "--rate-sent-share",
            settings.rate_sent_share,
            0.1,
            1.0,
            "SHARE",
            "of clouds, others are left out before voxels double");
  addNumber(app,
            "--rate-doublings",
            settings.rate_doublings,
            0u,
            8u,
            "N",
            "how often the edge of a voxel may double");
}

void
checkBudgetOptions(const CLI::App& app, const io::RateSettings& settings)
{
  if (settings.max_rate == 0.0)
    refuseOptions(app,
                  {"--rate-buffer", "--rate-temporal-filter", "--rate-sent-share"},
                  "has no effect without a limit: add --max-rate");
  if (settings.max_rate == 0.0 && settings.max_encode_ms == 0.0)
    refuseOptions(app,
                  {"--rate-doublings"},
                  "has no effect without a limit: add --max-rate or --max-encode-ms");
}

} // namespace tools
} // namespace pcl_ext
