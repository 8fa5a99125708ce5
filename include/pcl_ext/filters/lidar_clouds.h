// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/export.h>
#include <pcl_ext/filters/sensor_preprocessor.h>

#include <pcl/PCLPointCloud2.h>

#include <string>

namespace pcl_ext::PCL_EXT_ABI {

/** \addtogroup filters
 * @{ */

/** \brief Whether a cloud is that of a lidar that turns: its points have the rows by
 * which a PointOutlierRemoval judges them.
 * \param[in] cloud in the sensor's coordinates, of more than 2^20 points, which
 * such lidars do not have in a turn, the answer is false
 */
PCL_EXT_EXPORT bool
isOfLidar(const pcl::PCLPointCloud2& cloud);

/** \brief The fields that tell the order in which a lidar measured its points. */
struct OrderFields {
  /** \brief When a point was measured, any unit; empty: the first one of t, time,
   * timestamp, time_stamp and offset_time that a cloud has. */
  std::string time;
  /** \brief Laser, row of a point, 0 or more; empty: the first one of ring, channel and
   * line. */
  std::string ring;
};

/** \brief Sorts points as a lidar measured them: by time, points of the same time by
 * ring. Decoded clouds whose points are in the order of their voxels, or row by row,
 * get that of the sensor back, if these fields were kept (StreamSettings::fields).
 *
 * \param[in,out] cloud x, y, z as FLOAT32 or FLOAT64; is unorganised afterwards; points
 * with coordinates that are not finite are removed
 * \param[in] fields one value a point, any datatype
 * \return Ok, or why the cloud was left as it is: MissingField, InvalidField (several
 * values, or a time that is not a number), InvalidLayout
 */
PCL_EXT_EXPORT PreprocessingStatus
sortByTime(pcl::PCLPointCloud2& cloud, const OrderFields& fields = {});

/** \brief Puts points into rows and columns as a lidar measured them: a row for each
 * ring, a column for each time. For lidars whose points of a column have the same time.
 *
 * Columns begin with the first time. Where times are further apart than most, columns
 * without points are between them. Pixels without a point are as PCL has them: floating
 * point numbers are NaN, all else is 0.
 * \param[in,out] cloud as for sortByTime(); is organised afterwards
 * \param[in] size columns and rows; 0: as many as the points need
 * \param[in] fields one value a point, any datatype
 * \return Ok, or why the cloud was left as it is: MissingField; InvalidField (as for
 * sortByTime(), rings that are no row, two points of the same ring and time, times that
 * differ within columns); InvalidLayout (of the cloud, or more than 65,536 columns or
 * rows, or 2^24 pixels)
 */
PCL_EXT_EXPORT PreprocessingStatus
arrangeByRing(pcl::PCLPointCloud2& cloud,
              const io::ImageSize& size = {},
              const OrderFields& fields = {});

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI
