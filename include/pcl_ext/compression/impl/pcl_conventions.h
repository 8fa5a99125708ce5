/** \file
 * \brief What the class with PCL's interface does that depends on no point type.
 */
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/status.h>

#include <pcl/compression/compression_profiles.h>

#include <array>
#include <cstdint>
#include <istream>
#include <ostream>
#include <vector>

namespace pcl_ext {
namespace io {
namespace detail {

/** \brief The settings that PCL's constructor arguments stand for. */
PCL_EXT_EXPORT IntensityCompressionSettings
settingsOfProfile(pcl::io::compression_Profiles_e profile,
                  bool show_statistics,
                  double octree_resolution,
                  unsigned int i_frame_rate);

/** \brief A resolution that PCL's octree accepts, whatever the user's. */
PCL_EXT_EXPORT double
octreeResolution(const IntensityCompressionSettings& settings);

/** \brief The box of an octree whose voxels are those of a grid. */
struct OctreeBox {
  std::array<double, 3> min; ///< metres
  std::array<double, 3> max;
};

/** \brief The box of an octree for a grid, metres.
 *
 * PCL divides a point's distance from the corner, the codec its coordinate. The lower
 * corner is moved outwards by the rounding between the two, so that a point on a voxel's
 * boundary is in the same voxel for both.
 */
PCL_EXT_EXPORT OctreeBox
octreeBox(const VoxelGrid& grid);

/** \brief OutputFailed unless an output stream can be written. */
PCL_EXT_EXPORT CompressionStatus
checkOutput(const std::ostream& output);

/** \brief Writes a frame to a stream that may be set to throw. */
PCL_EXT_EXPORT CompressionStatus
writeFrame(const std::vector<std::uint8_t>& bytes, std::ostream& output);

/** \brief Decodes the next frame of a stream that may be set to throw. Sets the stream's
 * end and fail bits at its end, as a read does. */
PCL_EXT_EXPORT CompressionStatus
readFrame(std::istream& input, FrameDecoder& decoder, VoxelFrame& frame);

/** \brief Prints the figures of a frame through PCL's console. */
PCL_EXT_EXPORT void
printStatistics(const char* title, const FrameStatistics& statistics);

} // namespace detail
} // namespace io
} // namespace pcl_ext
