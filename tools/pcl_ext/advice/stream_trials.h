// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief A stream's clouds encoded with several voxel edges and efforts.
 */
#pragma once

#include "advice/setting_choice.h"
#include "inputs/held_clouds.h"
#include "options/encoding_options.h"

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::tools {

struct TrialOptions {
  EncodingOptions encoding;       ///< all other settings
  std::optional<double> max_rate; ///< bits a second, above which larger edges are tried
  std::optional<double> edge; ///< the only one to try, metres; none: those that suit
  std::optional<io::Effort> effort; ///< the only one to try; none: all
  double usual_period = 0.1;        ///< seconds from cloud to cloud where nothing tells
};

struct StreamTrials {
  std::vector<EdgeTrial> edges; ///< ascending; none: see fault
  ChoiceLimits limits;
  Choice choice;     ///< if there are edges
  std::string fault; ///< why nothing was encoded
  IntensityLaw law = IntensityLaw::None;
  double points = 0.0; ///< mean of a cloud; those that are encoded
};

/** \brief Tries seven edges, the first about that at which points begin to share
 * voxels, and up to three more as long as none keeps the limits; then one between that
 * which does and the finer one. Points that are all kept need no surfaces without
 * holes: their first edge is 1 mm. Takes some 20 seconds for all streams together.
 * \param[in] stream with at least one cloud
 * \param[in] streams their number, which share the time
 * \param[in] advance is called after each trial
 * \throws UsageError if the settings are not for these clouds
 */
StreamTrials
tryStream(const TrialOptions& options,
          const HeldClouds& stream,
          std::size_t streams,
          const std::function<void()>& advance);

} // namespace pcl_ext::tools
