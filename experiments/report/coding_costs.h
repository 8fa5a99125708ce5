/** \file
 * \brief What coding a stream costs, whether as voxels or as images.
 */
#pragma once

#include "measuring/result_file.h"
#include "measuring/samples.h"

#include <cstddef>

namespace pcl_ext {
namespace report {

/** \brief Sizes and times of a stream's frames. */
class CodingCosts {
public:
  /** \brief For a stream.
   * \param[in] frame_rate frames a second
   */
  explicit CodingCosts(double frame_rate) : frame_rate_(frame_rate) {}

  /** \brief Adds a frame.
   * \param[in] size bytes of the frame
   * \param[in] cropped_points points within the crop box, 16 bytes each before coding
   * \param[in] encode_ms, decode_ms its times, milliseconds
   */
  void
  add(std::size_t size, double cropped_points, double encode_ms, double decode_ms)
  {
    const auto bytes = static_cast<double>(size);
    bytes_.add(bytes);
    ratio_.add(16.0 * cropped_points / bytes);
    megabits_per_second_.add(8e-6 * bytes * frame_rate_);
    encode_ms_.add(encode_ms);
    decode_ms_.add(decode_ms);
  }

  void
  write(const measuring::Subject& subject, measuring::ResultFile& results) const
  {
    results.add(subject, "bytes", bytes_);
    results.add(subject, "ratio", ratio_);
    results.add(subject, "megabits_per_second", megabits_per_second_);
    results.add(subject, "encode_ms", encode_ms_);
    results.add(subject, "decode_ms", decode_ms_);
  }

private:
  double frame_rate_;
  measuring::Samples bytes_;
  measuring::Samples ratio_;
  measuring::Samples megabits_per_second_;
  measuring::Samples encode_ms_;
  measuring::Samples decode_ms_;
};

} // namespace report
} // namespace pcl_ext
