// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/filters/point_outlier_removal.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/intensity/intensity_law.h>
#include <pcl_ext/rigid_pose.h>

#include "temporal_filter.h"

#include <pybind11/pybind11.h>

#include <optional>

namespace pcl_ext::python {

namespace py = pybind11;

struct ArrayEncoderSettings {
  io::EncoderSettings codec;
  std::optional<io::DepthLaw> depth_law;
  std::optional<IntensityLaw> law; ///< none: by the first cloud with points
  std::optional<RuntimeSensor> sensor;
  std::optional<WorldPose> sensor_pose; ///< sensor -> cloud; none: identity
};

/** \brief Reads and checks the settings of an encoder.
 * \param[in] values a value for each name that Encoder.__init__ has
 * \throws py::type_error, py::value_error with the name and what is allowed
 */
ArrayEncoderSettings
readArrayEncoderSettings(const py::dict& values);

/** \brief Reads and checks the limits of a decoder.
 * \param[in] defaults of what is None; nothing may be None without them
 */
io::DecoderLimits
readLimits(const py::dict& values,
           const std::optional<io::DecoderLimits>& defaults = std::nullopt);

VoxelOutlierRemovalSettings
readRemovalSettings(const py::dict& values);

/** \brief Reads and checks the settings of a removal of points. */
PointOutlierRemovalSettings
readPointRemovalSettings(const py::dict& values);

TemporalFilterSettings
readTemporalFilterSettings(const py::dict& values);

/** \brief A pose from a matrix of 4 x 4 numbers. */
WorldPose
readPose(const py::object& matrix);

/** \brief The settings of an encoder, for tests: a dict for each, with its default and
 * its range, and why it is no keyword. */
py::list
encoderSettings();

/** \brief The defaults of what else is set, by the names of the settings. */
py::dict
defaultSettings();

} // namespace pcl_ext::python
