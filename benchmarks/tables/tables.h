// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The tables of doc/benchmarks.md. Each function measures and prints.
 */
#pragma once

#include "measuring/options.h"

namespace pcl_ext {
namespace measuring {

/** \brief The sensor of the robot cell whose stream is compressed, if it is one
 * alone. */
constexpr unsigned int first_sensor = 1;

/** \brief Each effort against the published layout and PCL's class, three workloads. */
void
printEfforts(const Options& options, std::ostream& output);

/** \brief From the sensor's organised cloud to bytes, against PCL's filters and
 * class. */
void
printFromSensor(const Options& options, std::ostream& output);

/** \brief All coders on the robot cell at 4 cm, with allocations and errors. */
void
printPeers(const Options& options, std::ostream& output);

/** \brief All coders on recorded streams. */
void
printRecorded(const Options& options, std::ostream& output);

/** \brief All points of recorded streams, coordinates alone, with the same largest error
 * in all coders. */
void
printPoints(const Options& options, std::ostream& output);

/** \brief PCL's profiles in PCL's class and in this library's, by point type, robot
 * cell and recorded streams. */
void
printProfiles(const Options& options, std::ostream& output);

} // namespace measuring
} // namespace pcl_ext
