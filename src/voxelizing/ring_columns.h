// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxelizing/ray_fit.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Finds the columns of the points of a spinning sensor whose rows are known, from
 * their azimuths. */
class RingColumns {
public:
  /** \brief Sets the cloud that fit() and assign() are for.
   * \param[in] points with rows, in the coordinates of the sensor
   */
  void
  setPoints(const std::vector<PixelPoint>& points);

  /** \brief Finds how many columns a turn has, and where those of each row are.
   * \param[in] points those of setPoints()
   * \param[in] rows number of rows
   * \param[in] most_pixels in all rows
   * \return false if azimuths have no common step, or there are too many pixels or rows
   */
  bool
  fit(const std::vector<PixelPoint>& points,
      std::uint32_t rows,
      std::uint64_t most_pixels);

  /** \brief Sets the columns of points; a further one at the same place has that of
   * another turn, as in scans that end behind their begin, and with several echoes; those
   * at the sensor, as drivers write missing ones, have any.
   * \param[in,out] points those of setPoints(): of the cloud of fit(), or of another one
   * of the same sensor
   * \param[out] shift how far the columns are turned against those of fit(), radians
   * \return false if there are too many at a place, or rows are others
   */
  bool
  assign(std::vector<PixelPoint>& points, double& shift);

  /** \brief Whether the azimuths of the points that were assigned are as near to their
   * columns as those that fit() found the columns of. */
  bool
  areAlike() const
  {
    return likeness_ >= tolerance * fitted_likeness_;
  }

  /** \brief Whether the points of fit() are clearly nearer to the columns that it found
   * than to those of another one that they were assigned to. */
  bool
  fitBetterThan(const RingColumns& others) const
  {
    return others.likeness_ < tolerance * fitted_likeness_;
  }

  /** \brief Columns of an image, 0 before fit(): those of a turn, or more. */
  std::uint32_t
  count() const
  {
    return count_;
  }

  /** \brief How many times count() columns the last assign() took. */
  std::uint32_t
  turns() const
  {
    return turns_;
  }

  /** \brief Number of rows. */
  std::uint32_t
  rows() const
  {
    return static_cast<std::uint32_t>(phases_.size());
  }

  /** \brief Angle between columns, radians. */
  double
  step() const;

  /** \brief Releases the memory of the last cloud; what fit() found stays. */
  void
  releaseMemory();

private:
  /** \brief Of how near azimuths are to columns. */
  static constexpr double tolerance = 0.95;

  struct RowAzimuth {
    std::uint32_t row;
    double azimuth; // radians
  };

  std::vector<RowAzimuth>
  sampleOf(const std::vector<PixelPoint>& points, std::size_t enough) const;

  double
  findStep(const std::vector<PixelPoint>& points, std::uint32_t rows) const;

  bool
  findColumns(const std::vector<RowAzimuth>& sample, std::uint32_t rows, double step);

  bool
  place(PixelPoint& point, double column);

  bool
  placeAnywhere(PixelPoint& point);

  std::uint32_t count_ = 0;
  double columns_of_turn_ = 0.0;
  double first_column_ = 0.0; // from straight ahead on, where the cloud of fit() begins
  std::vector<double> phases_; // azimuth of a column of each row, radians
  // How near azimuths are to columns, 1: all at the same distance.
  double likeness_ = 0.0;        // those of the last assign()
  double fitted_likeness_ = 0.0; // those of fit()
  // Of the current cloud; members so that their memory is reused.
  std::vector<double> azimuths_; // in a turn from its begin on, radians
  double turn_begin_ = 0.0;
  std::uint32_t turns_ = 1;
  std::vector<std::uint8_t> points_of_pixel_; // at a place of a turn
  std::vector<std::size_t> at_sensor_;        // points
  std::vector<std::uint32_t> free_columns_;   // of rows, that may be so
};

} // namespace pcl_ext::PCL_EXT_ABI::io
