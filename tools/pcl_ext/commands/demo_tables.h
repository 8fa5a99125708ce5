#pragma once

#include "commands/demo_stream.h"

#include <iosfwd>
#include <vector>

namespace pcl_ext {
namespace tools {

/** \brief Prints sizes and times of the streams. */
void
printSizes(const std::vector<DemoReport>& reports, std::ostream& output);

/** \brief Prints what denoising removes and keeps. */
void
printDenoising(const std::vector<DemoReport>& reports, std::ostream& output);

/** \brief Prints sizes, times and what is shown with the temporal filter, beside the
 * sizes without it; nothing if the streams themselves are filtered. */
void
printTemporalFilter(const std::vector<DemoReport>& reports, std::ostream& output);

} // namespace tools
} // namespace pcl_ext
