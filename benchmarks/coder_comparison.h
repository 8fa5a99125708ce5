/** \file
 * \brief Coders side by side on the same clouds.
 */
#pragma once

#include "decoded_checks.h"
#include "samples.h"
#include "stream_coder.h"
#include "workload.h"

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace benchmarks {

/** \brief What a coder did with a stream; samples are frames. */
struct CoderFigures {
  std::string name;
  Content content = Content::Points;
  Samples voxels; ///< of coders that keep points: those of the first coder
  Samples bytes;
  Samples encode_ms;
  Samples decode_ms;
  Samples encode_allocations;
  Samples decode_allocations;
  NearestDistances to_decoded;   ///< from each point that went in
  NearestDistances from_decoded; ///< from each point that came out

  double
  bytesPerVoxel() const
  {
    return bytes.sum() / voxels.sum();
  }
};

/** \brief The stream's own figures and those of all coders, in their order. */
struct Comparison {
  Samples points;
  std::vector<CoderFigures> coders;
};

/** \brief How a comparison is made. */
struct ComparisonSettings {
  std::size_t repetitions = 1; ///< of the whole stream, with new coders each time
  std::size_t error_every =
      0; ///< frames from one that is searched to the next; 0: none
};

using MakeCoders = std::function<StreamCoders(const Workload&)>;

/** \brief Gives each frame of a stream to all coders, one after the other, beginning
 * with another one each time.
 * \throws std::runtime_error naming coder and frame if what was decoded is not what was
 * encoded; there are no figures of unlike work
 */
Comparison
compareCoders(const InputStream& stream,
              const Workload& workload,
              const MakeCoders& make_coders,
              const ComparisonSettings& settings);

} // namespace benchmarks
} // namespace pcl_ext
