#pragma once

#include "denoising.h"
#include "measuring/cloud_sequence.h"
#include "stream_options.h"

#include <cstddef>
#include <string>

namespace pcl_ext {
namespace tools {

/** \brief Figures of a stream; sums over its frames. */
struct StreamReport {
  std::string name;
  std::string law;
  std::size_t frames = 0;
  std::size_t failed_frames = 0;  ///< could not be read or processed
  std::size_t points = 0;         ///< that are finite, before cropping
  std::size_t encoded_points = 0; ///< that are in a voxel
  std::size_t voxels = 0;
  std::size_t saturated_voxels = 0; ///< whose intensity is beyond the scale
  std::size_t bytes = 0;
  double preprocess_ms = 0.0;
  double encode_ms = 0.0;
  double decode_ms = 0.0;
  DenoisingReport denoising;
  std::string example_cloud; ///< path of a cloud that was written, if any
};

/** \brief Preprocesses, encodes, decodes and denoises a whole stream, shows a progress
 * bar meanwhile, checks that what was decoded is what was encoded, and writes the
 * decoded and the denoised clouds, which replace those of an earlier run at the end.
 * \param[in,out] sequence the stream's clouds
 * \param[in] options of the command line
 * \param[in] crop_box what to keep; none: everything
 * \return the sums; a frame that fails is reported on the console and not counted
 * \throws std::exception with a message for the user if nothing can be processed
 */
StreamReport
runStream(measuring::CloudSequence& sequence,
          const StreamOptions& options,
          const std::optional<io::BoundingBox>& crop_box);

} // namespace tools
} // namespace pcl_ext
