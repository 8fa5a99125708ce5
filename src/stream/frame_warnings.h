#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/intensity/intensity_model.h>

#include <cstddef>
#include <string>

namespace pcl_ext {
namespace io {

/** \brief What of a cloud is not in its frame, or changed, each with its number; empty
 * if nothing is. Points that are not finite are not mentioned: organised clouds have
 * them where there is no measurement.
 * \param[in] statistics of the frame
 * \param[in] settings of its encoder
 * \param[in] unit unit of the point intensities
 * \param[in] is_coarsened whether voxels are larger since the cloud is wide
 * \param[in] field_values of all fields in the frame
 */
std::string
frameWarning(const FrameStatistics& statistics,
             const EncoderSettings& settings,
             IntensityUnit unit,
             bool is_coarsened,
             std::size_t field_values = 0);

} // namespace io
} // namespace pcl_ext
