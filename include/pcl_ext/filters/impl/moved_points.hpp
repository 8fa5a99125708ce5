#pragma once

#include <pcl_ext/export.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace detail {

/** \brief Where points are moved, and which are kept. */
struct PointMove {
  /** \brief The rows of [rotation | translation], metres: sensor frame -> global frame. */
  std::array<std::array<float, 4>, 3> rows;
  std::array<float, 3> min; ///< corners of the crop box in the global frame, metres,
  std::array<float, 3> max; ///< both ends included; infinite: no crop box
};

/** \brief Consecutive points somewhere in memory: x, y, z as consecutive floats, metres. */
struct PointBytes {
  const unsigned char* first; ///< x of the first point; need not be aligned
  std::size_t stride;         ///< bytes from one x to the next, at least 12
  std::size_t count;          ///< at most MovedPoints::capacity
};

/** \brief What became of some points. */
struct MovedPoints {
  static constexpr std::size_t most = 256;

  std::size_t count = 0;      ///< points that were kept
  std::size_t not_finite = 0; ///< points left out as they are not finite when moved
  std::array<float, most>
      depths; ///< z of those kept, as it was before the move, metres
  std::array<std::uint32_t, most> sources; ///< which of the points they are
};

/** \brief Floats from one point to the next in what movePoints writes: pcl::PointXYZI. */
constexpr std::size_t moved_point_floats = 8;

/** \brief Moves points and drops those that are then not finite or outside the crop box.
 * \param[in] points what to move
 * \param[in] move where to
 * \param[out] output x, y, z and 1 of each point that was kept, moved_point_floats apart;
 * needs room for as many points as there are, and is undefined behind those kept
 * \param[out] moved the rest about them
 */
PCL_EXT_EXPORT void
movePoints(const PointBytes& points,
           const PointMove& move,
           float* output,
           MovedPoints& moved);

} // namespace detail
} // namespace pcl_ext
