// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Coders side by side on the same clouds.
 */
#pragma once

#include "coders/stream_coder.h"
#include "measuring/samples.h"
#include "measuring/workload.h"
#include "meters/decoded_checks.h"

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief Figures of one coder; a sample is a frame. */
struct CoderFigures {
  std::string name;
  Content content = Content::Points;
  Samples points;  ///< that went in
  Samples decoded; ///< points that came out
  Samples bytes;
  Samples encode_ms;
  Samples decode_ms;
  Samples encode_allocations;
  Samples decode_allocations;
  NearestDistances to_decoded;   ///< from each point that went in
  NearestDistances from_decoded; ///< from each point that came out
};

/** \brief The figures of all coders, in their order; the first one makes voxels. */
struct Comparison {
  std::vector<CoderFigures> coders;

  /** \brief Mean of a frame; of coders that keep points the first coder's. */
  double
  voxels(const CoderFigures& coder) const;

  double
  bytesPerVoxel(const CoderFigures& coder) const
  {
    return coder.bytes.mean() / voxels(coder);
  }
};

/** \brief Settings of a comparison. */
struct ComparisonSettings {
  std::size_t repetitions = 1; ///< of the whole stream, with new coders each time
  std::size_t error_every =
      0; ///< frames from one with position errors to the next; 0: none
  Keep keep = Keep::Preprocessed; ///< the clouds that the coders need
};

using MakeCoders = std::function<StreamCoders(const Workload&)>;

/** \brief Runs all coders on a stream, each in a process of its own.
 * \throws std::runtime_error with coder and frame if what was decoded is not what was
 * encoded
 */
Comparison
compareCoders(const InputStream& stream,
              const Workload& workload,
              const MakeCoders& make_coders,
              const ComparisonSettings& settings);

} // namespace measuring
} // namespace pcl_ext
