/** \file
 * \brief The tables of doc/benchmarks.md about many streams; each runs what it shows.
 */
#pragma once

#include "scale_options.h"

#include <iosfwd>

namespace pcl_ext {
namespace measuring {

/** \brief The most streams that are decoded in time, on one core and on all, and the
 * most that a gigabit carries. */
void
printManyStreams(const ScaleOptions& options, std::ostream& output);

/** \brief Six sensors at once. */
void
printSixSensors(const ScaleOptions& options, std::ostream& output);

} // namespace measuring
} // namespace pcl_ext
