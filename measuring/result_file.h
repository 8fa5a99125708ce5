/** \file
 * \brief The results of the measuring programs as a CSV file.
 */
#pragma once

#include "measuring/samples.h"

#include <cstddef>
#include <fstream>
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

/** \brief A CSV file with a line for each quantity: its mean, deviation and number of
 * samples. The order of lines is the order of subjects in a table. */
class ResultFile {
public:
  /** \brief Begins a new file.
   * \param[in] path empty: standard output
   * \throws std::runtime_error if it cannot be written
   */
  explicit ResultFile(const std::string& path);

  void
  add(const Subject& subject, const std::string& quantity, const Samples& samples);

  /** \brief A quantity without a deviation.
   * \param[in] samples frames that it is of, all together
   */
  void
  add(const Subject& subject,
      const std::string& quantity,
      double value,
      std::size_t samples = 1);

  /** \brief Ends the file.
   * \throws std::runtime_error if not all of it could be written
   */
  void
  close();

private:
  void
  addLine(const Subject& subject,
          const std::string& quantity,
          double mean,
          double deviation,
          std::size_t samples);

  std::string path_;
  std::filebuf file_;
  std::ostream
      output_; ///< to the file, or to standard output; bad if it cannot be written
};

} // namespace measuring
} // namespace pcl_ext
