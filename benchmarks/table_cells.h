/** \file
 * \brief Cells of the tables that compare coders.
 */
#pragma once

#include "coder_comparison.h"
#include "measuring/samples.h"

#include <string>

namespace pcl_ext {
namespace measuring {

/** \brief The workload of a table. */
Workload
workloadAt(double resolution,
           unsigned int i_frame_rate,
           IntensityLaw law = IntensityLaw::Count);

/** \brief "median (mean)" */
std::string
medianAndMean(const Samples& samples);

/** \brief "2.1x" */
std::string
factor(double faster);

/** \brief The median, and how much faster it is than a reference's. */
std::string
timeAgainst(const Samples& samples, const Samples& reference);

/** \brief "+2.1 %" */
std::string
signedPercent(double percent);

/** \brief Bytes against the published layout's; empty for a coder that carries
 * something else. */
std::string
againstPublished(const CoderFigures& coder, const Comparison& comparison);

/** \brief PCL's class in voxel-grid mode, which is in all comparisons. */
const CoderFigures&
pclOf(const Comparison& comparison);

} // namespace measuring
} // namespace pcl_ext
