#pragma once

#include "cloud_sequence.h"
#include "stream_options.h"

#include <cstddef>
#include <string>

namespace pcl_ext {
namespace tools {

/** \brief What a stream cost; sums over its frames. */
struct StreamReport {
  std::string name;
  std::string law;
  std::size_t frames = 0;
  std::size_t points = 0;         ///< that are finite, before cropping
  std::size_t cropped_points = 0; ///< that were encoded
  std::size_t voxels = 0;
  std::size_t bytes = 0;
  std::size_t kept_voxels = 0; ///< after denoising
  double preprocess_ms = 0.0;
  double encode_ms = 0.0;
  double decode_ms = 0.0;
  double denoise_ms = 0.0;
};

/** \brief Preprocesses, encodes, decodes and denoises a whole stream, shows a progress
 * bar meanwhile, checks that what was decoded is what was encoded, and writes the
 * decoded clouds.
 * \param[in,out] sequence the stream's clouds
 * \param[in] options of the command line
 * \param[in] crop_box what to keep; none: everything
 * \throws std::runtime_error with a sentence for the user if anything fails
 */
StreamReport
runStream(CloudSequence& sequence,
          const StreamOptions& options,
          const std::optional<io::BoundingBox>& crop_box);

} // namespace tools
} // namespace pcl_ext
