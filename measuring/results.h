// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Results as lines of CSV, for programs that read them.
 */
#pragma once

#include "measuring/samples.h"

#include <cstddef>
#include <ostream>
#include <string>

namespace pcl_ext {
namespace measuring {

/** \brief What a result is of. Names have no comma and no line end. */
struct Subject {
  std::string experiment; ///< the table of the result
  std::string sensor;
  std::string coder;       ///< or the method
  double resolution = 0.0; ///< voxel edge, metres; 0 where there are no voxels
};

/** \brief Prints a header, and a line for each quantity: its mean, deviation and number
 * of samples. The order of lines is the order of subjects in a table. */
class Results {
public:
  explicit Results(std::ostream& output);

  void
  add(const Subject& subject, const std::string& quantity, const Samples& samples);

  /** \brief A quantity without a deviation; nothing if it is NaN.
   * \param[in] samples frames that it is of, all together
   */
  void
  add(const Subject& subject,
      const std::string& quantity,
      double value,
      std::size_t samples = 1);

private:
  void
  addLine(const Subject& subject,
          const std::string& quantity,
          double mean,
          double deviation,
          std::size_t samples);

  std::ostream& output_;
};

} // namespace measuring
} // namespace pcl_ext
