#include "decoding_options.h"

#include "encoding_options.h"
#include "options.h"

#include <algorithm>

namespace pcl_ext {
namespace tools {

void
addLimits(CLI::App& app, io::DecoderLimits& limits)
{
  constexpr std::size_t most = std::size_t{1} << 24;
  app.add_option_function<std::size_t>(
         "--max-voxels",
         [&limits](std::size_t voxels) {
           limits.max_voxels = voxels;
           constexpr std::size_t bytes_of_voxel = 16;
           limits.max_frame_bytes =
               std::max(limits.max_frame_bytes, bytes_of_voxel * voxels);
         },
         "refuse frames with more (1048576)")
      ->check(CLI::Range(std::size_t{1}, most).description(""))
      ->type_name("N");
}

void
addDecodingOptions(CLI::App& app, DecodingOptions& options)
{
  app.add_option("--min-intensity", options.min_intensity, "leave out voxels below")
      ->check(refuseNan)
      ->type_name("I");
  addOutlierRemoval(app,
                    "leave out noise, as VoxelOutlierRemoval finds it",
                    options.removes_outliers,
                    options.unit);
  addLimits(app, options.limits);
}

} // namespace tools
} // namespace pcl_ext
