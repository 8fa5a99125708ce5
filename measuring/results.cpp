// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "measuring/results.h"

#include <cmath>

namespace pcl_ext {
namespace measuring {

Results::Results(std::ostream& output) : output_(output)
{
  output_ << "experiment,sensor,coder,resolution_cm,quantity,mean,deviation,samples\n";
}

void
Results::addLine(const Subject& subject,
                 const std::string& quantity,
                 double mean,
                 double deviation,
                 std::size_t samples)
{
  const auto digits = output_.precision(10);
  output_ << subject.experiment << ',' << subject.sensor << ',' << subject.coder << ','
          << 100.0 * subject.resolution << ',' << quantity << ',' << mean << ','
          << deviation << ',' << samples << '\n';
  output_.precision(digits);
}

void
Results::add(const Subject& subject,
             const std::string& quantity,
             const Samples& samples)
{
  addLine(subject, quantity, samples.mean(), samples.deviation(), samples.count());
}

void
Results::add(const Subject& subject,
             const std::string& quantity,
             double value,
             std::size_t samples)
{
  if (!std::isnan(value))
    addLine(subject, quantity, value, 0.0, samples);
}

} // namespace measuring
} // namespace pcl_ext
