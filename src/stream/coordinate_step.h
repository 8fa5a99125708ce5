#pragma once

#include <pcl_ext/compression/point_view.h>

#include <limits>

namespace pcl_ext {
namespace io {

/** \brief The largest step of which all coordinates of a cloud are multiples, to a
 * quarter of the resolution.
 *
 * Recorded coordinates are often whole millimetres or centimetres. Voxels that are
 * centred on these keep them as they are; finer ones take more bytes for the same
 * points.
 * \param[in] points the cloud
 * \param[in] resolution metres
 * \param[in] largest step to look for, metres
 * \return 0.1, 0.05, 0.02, 0.01 m, ... 0.0001 m, at least twice the resolution; 0 if it
 * is none of these, or points are further than 2^20 steps from the world's origin; NaN
 * if no point is finite
 */
double
findCoordinateStep(PointBatches& points,
                   double resolution,
                   double largest = std::numeric_limits<double>::infinity());

} // namespace io
} // namespace pcl_ext
