#include <pcl_ext/compression/impl/pcl_conventions.h>

#include <pcl/console/print.h>

#include <cmath>
#include <exception>
#include <limits>
#include <string>

namespace pcl_ext {
namespace io {
namespace detail {

IntensityCompressionSettings
settingsOfProfile(pcl::io::compression_Profiles_e profile,
                  bool show_statistics,
                  double octree_resolution,
                  unsigned int i_frame_rate)
{
  IntensityCompressionSettings settings;
  settings.show_statistics = show_statistics;
  settings.resolution = octree_resolution;
  settings.i_frame_rate = i_frame_rate;
  // Values that are no profile count as MANUAL_CONFIGURATION.
  const int index = static_cast<int>(profile);
  if (index >= 0 && index < static_cast<int>(pcl::io::COMPRESSION_PROFILE_COUNT)) {
    const auto& configuration = pcl::io::compressionProfiles_[index];
    settings.resolution = configuration.octreeResolution;
    settings.i_frame_rate = configuration.iFrameRate;
    if (profile >= pcl::io::LOW_RES_OFFLINE_COMPRESSION_WITHOUT_COLOR)
      settings.effort = Effort::Small;
  }
  return settings;
}

double
octreeResolution(const IntensityCompressionSettings& settings)
{
  return checkSettings(settings).ok() ? settings.resolution
                                      : IntensityCompressionSettings().resolution;
}

OctreeBox
octreeBox(const VoxelGrid& grid)
{
  const double side = static_cast<double>(grid.size()) * grid.resolution;
  OctreeBox box{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double voxels = std::abs(static_cast<double>(grid.first_index[axis])) +
                          static_cast<double>(grid.size());
    const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * voxels;
    box.min[axis] = grid.lowerCorner(axis) - rounding * grid.resolution;
    box.max[axis] = grid.lowerCorner(axis) + side;
  }
  return box;
}

CompressionStatus
checkOutput(const std::ostream& output)
{
  if (output.good())
    return {};
  return {CompressionCode::OutputFailed,
          "the output stream had failed or ended before; clear() makes it writable"};
}

CompressionStatus
writeFrame(const std::vector<std::uint8_t>& bytes, std::ostream& output)
{
  bool is_written = false;
  try {
    output.write(reinterpret_cast<const char*>(bytes.data()),
                 static_cast<std::streamsize>(bytes.size()));
    output.flush();
    is_written = output.good();
  }
  catch (const std::exception&) {
    // A stream may be set to throw; the status says the same.
  }
  if (is_written)
    return {};
  return {CompressionCode::OutputFailed,
          "the output stream did not take the frame's " + std::to_string(bytes.size()) +
              " bytes"};
}

CompressionStatus
readFrame(std::istream& input, FrameDecoder& decoder, VoxelFrame& frame)
{
  if (input.rdbuf() == nullptr)
    return {CompressionCode::InputFailed, "the input stream has no buffer"};
  CompressionStatus status = decoder.decode(*input.rdbuf(), frame);
  if (status.code() == CompressionCode::EndOfStream ||
      status.code() == CompressionCode::NoFrame) {
    try {
      input.setstate(std::ios_base::eofbit | std::ios_base::failbit);
    }
    catch (const std::exception&) {
      // A stream may be set to throw; the bits are set all the same.
    }
  }
  return status;
}

void
printStatistics(const char* title, const FrameStatistics& statistics)
{
  const CodedFrameStatistics& coding = statistics.coding;
  PCL_INFO("*** POINTCLOUD %s ***\n", title);
  PCL_INFO("Frame ID: %u\n", coding.frame_number);
  PCL_INFO("Frame type: %s\n", coding.is_i_frame ? "Intra frame" : "Prediction frame");
  if (statistics.voxelization.points > 0) {
    const VoxelizationStatistics& voxelization = statistics.voxelization;
    PCL_INFO("Number of points: %zu, of these not finite: %zu, outside the box: %zu, "
             "outside the grid: %zu\n",
             voxelization.points,
             voxelization.points_not_finite,
             voxelization.points_outside_box,
             voxelization.points_outside_grid);
    PCL_INFO("Compression ratio to 16 bytes a point: %.2f\n",
             statistics.compressionRatio());
  }
  PCL_INFO("Number of voxels: %zu\n", coding.voxels);
  PCL_INFO("Size of compressed frame: %zu bytes (header %zu, occupancy %zu, intensity "
           "%zu)\n",
           coding.bytes,
           coding.header_bytes,
           coding.occupancy_bytes,
           coding.intensity_bytes);
  PCL_INFO("Bytes per voxel: %.3f\n\n", statistics.bytesPerVoxel());
}

} // namespace detail
} // namespace io
} // namespace pcl_ext
