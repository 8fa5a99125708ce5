// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cloud_columns.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <vector>

namespace pcl_ext::python {

namespace py = pybind11;

/** \brief The arrays of a cloud, checked. They are kept alive, but not kept from being
 * changed. To be constructed and destroyed with the GIL held. */
class CloudArrays {
public:
  /** \brief Finds the points in what a caller gave.
   * \param[in] xyz array of shape (N, 3) or (rows, columns, 3), or structured with
   * fields x, y, z and possibly intensity, rgb, rgba or r, g, b, and further fields
   * \param[in] intensity None, or numbers in the shape of the cloud
   * \param[in] colour None, or uint8 of shape (..., 3) or (..., 4)
   * \throws py::type_error, py::value_error with the argument and a remedy
   */
  CloudArrays(const py::object& xyz,
              const py::object& intensity,
              const py::object& colour);

  const CloudColumns&
  columns() const
  {
    return columns_;
  }

  /** \brief Shape of the cloud: that of xyz, without its last dimension of 3. */
  const std::vector<py::ssize_t>&
  shape() const
  {
    return shape_;
  }

  /** \brief True if the intensities are an argument, not a field that came along. */
  bool
  hasIntensityArgument() const
  {
    return has_intensity_argument_;
  }

private:
  void
  setImage();

  void
  takeFields(const py::array& points);

  void
  takeCoordinates(py::array points);

  void
  takeIntensity(const py::object& intensity);

  void
  takeColour(const py::object& colour);

  void
  takeColourFields(const py::array& points);

  void
  takeFurtherFields(const py::array& points);

  Column
  columnOf(const py::array& numbers);

  CloudColumns columns_;
  std::vector<py::ssize_t> shape_; // of the cloud
  bool has_intensity_argument_ = false;
  std::vector<py::array> arrays_; // what the columns point to
};

} // namespace pcl_ext::python
