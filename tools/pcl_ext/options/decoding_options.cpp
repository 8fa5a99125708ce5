#include "options/decoding_options.h"

#include "options/encoding_options.h"
#include "options/options.h"
#include "options/text_values.h"

#include <algorithm>

namespace pcl_ext {
namespace tools {

void
addLimits(CLI::App& app, std::optional<io::DecoderLimits>& limits)
{
  constexpr std::size_t most = std::size_t{1} << 24;
  app.add_option_function<std::size_t>(
         "--max-voxels",
         [&limits](std::size_t voxels) {
           constexpr std::size_t of_voxel = 16; // bytes, and points
           constexpr std::size_t values_of_voxel = 4 * of_voxel;
           const io::DecoderLimits least;
           limits = {std::max(least.max_frame_bytes, of_voxel * voxels),
                     voxels,
                     std::max(least.max_points, of_voxel * voxels),
                     std::max(least.max_field_values, values_of_voxel * voxels)};
         },
         "refuse frames with more (8 for each byte of the recording, 2^20 to 2^22)")
      ->check(CLI::Range(std::size_t{1}, most).description(""))
      ->type_name("N");
}

void
addDecodingOptions(CLI::App& app, DecodingOptions& options)
{
  app.add_option("--min-intensity", options.min_intensity, "leave out voxels below")
      ->check(refuseNan)
      ->type_name("I");
  CLI::Option* const removal =
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
        options.sensor_position = parsePosition("sensor-position", text);
      })
      ->needs(removal);
  addLimits(app, options.limits);
}

} // namespace tools
} // namespace pcl_ext
