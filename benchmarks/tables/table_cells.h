// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Cells of the tables that compare coders.
 */
#pragma once

#include "measuring/samples.h"
#include "meters/coder_comparison.h"

#include <string>

namespace pcl_ext {
namespace measuring {

/** \brief A workload with an I-frame every 30. */
Workload
workloadAt(double resolution, IntensityLaw law = IntensityLaw::Count);

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
 * something else, and where the published layout is not compared. */
std::string
againstPublished(const CoderFigures& coder, const Comparison& comparison);

/** \brief PCL's class in voxel-grid mode, which is in all comparisons. */
const CoderFigures&
pclOf(const Comparison& comparison);

} // namespace measuring
} // namespace pcl_ext
