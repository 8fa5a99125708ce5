/** \file
 * Fuzz target: any points, as a stream of clouds, come back as the voxels that went in,
 * in either format, and encoding the decoded frames again gives the same bytes.
 */
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/frame_encoder.h>
#include <pcl_ext/compression/voxelizer.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::io;

void
require(bool condition)
{
  if (!condition)
    std::abort();
}

IntensityCompressionSettings
settingsOf(std::uint8_t choice, bool is_companded)
{
  IntensityCompressionSettings settings;
  settings.resolution = (choice & 1) != 0 ? 0.04 : 1000.0;
  settings.format =
      (choice & 2) != 0 ? StreamFormat::Published : StreamFormat::Version1;
  settings.i_frame_rate = 3;
  if (settings.format == StreamFormat::Version1) {
    settings.intensity_bits = choice >> 4;
    settings.intensity_curve =
        is_companded ? IntensityCurve::Companded : IntensityCurve::Linear;
  }
  if ((choice & 4) != 0)
    settings.bounding_box = BoundingBox{{-3.0, -2.0, 0.1}, {3.0, 2.5, 4.0}};
  return settings;
}

} // namespace

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  if (size < 2)
    return 0;
  const IntensityCompressionSettings settings = settingsOf(data[0], data[1] >= 128);
  require(checkSettings(settings).ok());
  const std::size_t points_per_cloud = 1 + data[1] % 64;
  std::vector<float> numbers((size - 2) / sizeof(float));
  if (!numbers.empty())
    std::memcpy(numbers.data(), data + 2, numbers.size() * sizeof(float));

  const IntensityUnit unit =
      (data[0] & 8) != 0 ? IntensityUnit::Native : IntensityUnit::Share;
  Voxelizer voxelizer(settings, unit);
  FrameEncoder encoder(settings.format, settings.i_frame_rate);
  FrameEncoder second_encoder(settings.format, settings.i_frame_rate);
  FrameDecoder decoder;
  VoxelFrame frame;
  VoxelFrame decoded;
  std::vector<std::uint8_t> bytes;
  std::vector<std::uint8_t> bytes_again;
  for (std::size_t begin = 0; begin < numbers.size(); begin += 4 * points_per_cloud) {
    const std::size_t points = (numbers.size() - begin) / 4;
    const PointView view{numbers.data() + begin,
                         4,
                         numbers.data() + begin + 3,
                         4,
                         points < points_per_cloud ? points : points_per_cloud};
    const VoxelizationStatistics statistics =
        voxelizer.voxelize(view, encoder.isIFrameDue(), frame);
    require(statistics.points_used + statistics.points_not_finite +
                statistics.points_outside_box + statistics.points_outside_grid ==
            view.count);
    require(encoder.encode(frame, std::nullopt, bytes).ok());
    require(decoder.decode(bytes.data(), bytes.size(), decoded).ok());
    require(decoded.keys == frame.keys && decoded.intensities == frame.intensities);
    require(decoded.intensity_scale == frame.intensity_scale);
    // The published layout knows a grid by its box, not by its place on a lattice.
    if (settings.format == StreamFormat::Version1)
      require(decoded.grid == frame.grid);
    require(second_encoder
                .encode(settings.format == StreamFormat::Version1 ? decoded : frame,
                        std::nullopt,
                        bytes_again)
                .ok());
    require(bytes == bytes_again);
  }
  return 0;
}
