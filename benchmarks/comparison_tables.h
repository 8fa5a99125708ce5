/** \file
 * \brief The tables of doc/benchmarks.md; each runs what it shows.
 */
#pragma once

#include "comparison_options.h"

#include <iosfwd>

namespace pcl_ext {
namespace measuring {

/** \brief All coders on the robot cell at 4 cm. */
void
printPeers(const ComparisonOptions& options, std::ostream& output);

/** \brief Each effort against the published layout and PCL's class, three workloads. */
void
printEfforts(const ComparisonOptions& options, std::ostream& output);

/** \brief Milliseconds of each stage. */
void
printStages(const ComparisonOptions& options, std::ostream& output);

/** \brief From the sensor's organised cloud to bytes, against PCL's passes. */
void
printRawToBytes(const ComparisonOptions& options, std::ostream& output);

/** \brief Recorded streams, a row for each folder. */
void
printRecorded(const ComparisonOptions& options, std::ostream& output);

/** \brief Bytes and changed decisions over the bits of a count, linear and companded. */
void
printBits(const ComparisonOptions& options, std::ostream& output);

/** \brief Time and bytes over the number of points. */
void
printGrowthWithPoints(const ComparisonOptions& options, std::ostream& output);

/** \brief Time and bytes over the voxel edge. */
void
printGrowthWithEdge(const ComparisonOptions& options, std::ostream& output);

} // namespace measuring
} // namespace pcl_ext
