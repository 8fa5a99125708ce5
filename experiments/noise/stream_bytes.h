/** \file
 * \brief What a stream shrinks by when its noise is removed before it is encoded.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace pcl_ext {

namespace report {
class ResultFile;
}

namespace noise {

/** \brief What one way to send a stream comes to; means of a frame. */
struct SentBytes {
  std::string law;
  std::string effort;
  std::string filter; ///< at the sensor
  double voxels = 0.0;
  double bytes = 0.0;
  double less_percent = 0.0; ///< bytes, than without a filter
};

/** \brief Encodes one sensor's stream with and without the filter, and with one that knows
 * the truth. */
std::vector<SentBytes>
measureStreamBytes(std::uint32_t seed,
                   unsigned int sensor,
                   std::uint32_t frames,
                   double resolution);

/** \brief Prints them as Markdown. */
void
print(const std::vector<SentBytes>& sent, std::ostream& output);

/** \brief Adds them to the results, experiment `noise_bytes:` and law and effort. */
void
addResults(const std::vector<SentBytes>& sent,
           unsigned int sensor,
           std::size_t frames,
           double resolution,
           report::ResultFile& results);

} // namespace noise
} // namespace pcl_ext
