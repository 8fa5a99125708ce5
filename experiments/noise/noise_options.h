/** \file
 * \brief The command line of measure_noise.
 */
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief What measure_noise can measure. */
enum class NoisePart { All, Laws, Peers, Time, Bytes, Weights, Fused };

/** \brief All that is chosen; within its range. */
struct NoiseOptions {
  std::vector<unsigned int> sensors; ///< 1 to 6, and 7 where only the laws are wanted
  std::uint32_t frames = 300;
  std::uint32_t seed = 1;
  double resolution = 0.04; ///< voxel edge, metres
  NoisePart part = NoisePart::All;
  std::string results_file; ///< empty: results are only printed

  bool
  wants(NoisePart wanted) const
  {
    return part == NoisePart::All || part == wanted;
  }
};

/** \brief Reads the command line.
 * \return nothing if only the help was asked for, which is then printed
 * \throws std::exception with a sentence for the user if the line makes no sense
 */
std::optional<NoiseOptions>
parseNoiseOptions(int argc, const char* const* argv);

} // namespace noise
} // namespace pcl_ext
