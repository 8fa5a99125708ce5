/** \file
 * \brief What a stream shrinks by when its noise is removed before it is encoded.
 */
#pragma once

#include <cstdint>
#include <iosfwd>

namespace pcl_ext {
namespace noise {

/** \brief Encodes one sensor's stream with and without the filter and prints the bytes. */
void
printStreamBytes(std::uint32_t seed,
                 unsigned int sensor,
                 std::uint32_t frames,
                 double resolution,
                 std::ostream& output);

} // namespace noise
} // namespace pcl_ext
