#pragma once

#include <pcl_ext/compression/voxel_grid.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

/** \brief How far a sensor sees in each direction, by the voxels of a frame.
 *
 * Directions are squares on the six faces of a cube around the sensor, 0.35 degrees
 * wide in the middle of a face and half as wide at its edges. A depth is the distance
 * along the face's axis, in voxels. Each result of floating-point arithmetic is one
 * operation, so that no compiler rounds otherwise.
 */
class SeenDepths {
public:
  /** \brief Depths that differ by less may be of one surface, voxels. */
  static constexpr float margin = 2.0f;

  /** \brief Sets the depths to those of a frame.
   * \param[in] keys its voxels
   * \param[in] grid of the frame
   * \param[in] position of the sensor, in the grid's coordinates, metres; finite
   */
  void
  assign(const std::vector<std::uint64_t>& keys,
         const io::VoxelGrid& grid,
         const std::array<double, 3>& position)
  {
    clear();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double voxels =
          std::clamp((position[axis] - grid.centre(axis, 0)) / grid.resolution,
                     -farthest,
                     farthest);
      position_[axis] = static_cast<float>(voxels);
      nearest_[axis] = static_cast<std::int64_t>(std::round(voxels));
    }
    squares_.resize(keys.size());
    std::size_t count = 0;
    for (const std::uint64_t key : keys)
      if (const std::optional<Direction> direction = directionOf(key)) {
        float& depth = depthAt(direction->face, direction->row, direction->column);
        depth = std::min(depth, direction->depth);
        squares_[count++] = &depth;
      }
    squares_.resize(count);
  }

  /** \brief Releases memory that assign() allocates again. */
  void
  releaseMemory()
  {
    *this = SeenDepths();
  }

  /** \brief True if a voxel of the frame is farther than others in its direction, so
   * that the sensor cannot be at its position. */
  bool
  isBehindOthers(std::uint64_t key) const
  {
    const std::optional<Direction> at = directionOf(key);
    return at && faces_[at->face][at->row * width + at->column] + margin < at->depth;
  }

  /** \brief True if the sensor sees through the place of a voxel: what it sees in the
   * direction of the voxel and around is all farther. False where it sees nothing. */
  bool
  isSeenThrough(std::uint64_t key) const
  {
    const std::optional<Direction> at = directionOf(key);
    if (!at || faces_[at->face].empty())
      return false;
    // Half of a voxel, in squares.
    const std::size_t radius = at->depth <= 28.0f    ? 3
                               : at->depth <= 51.0f  ? 2
                               : at->depth <= 256.0f ? 1
                                                     : 0;
    const std::size_t top = at->row - std::min(at->row, radius);
    const std::size_t bottom = std::min(at->row + radius, last);
    const std::size_t left = at->column - std::min(at->column, radius);
    const std::size_t right = std::min(at->column + radius, last);
    bool is_seen = false;
    for (std::size_t row = top; row <= bottom; ++row)
      for (std::size_t column = left; column <= right; ++column) {
        const float depth = faces_[at->face][row * width + column];
        if (depth <= at->depth + margin)
          return false;
        is_seen = is_seen || depth != unseen;
      }
    return is_seen;
  }

  /** \brief Square of the distance of a voxel from the sensor, in voxels; the sensor's
   * position is rounded to a voxel. */
  std::uint64_t
  squaredDistance(std::uint64_t key) const
  {
    const io::VoxelPosition at = io::voxelPosition(key);
    const std::int64_t x = std::int64_t{at.x} - nearest_[0];
    const std::int64_t y = std::int64_t{at.y} - nearest_[1];
    const std::int64_t z = std::int64_t{at.z} - nearest_[2];
    return static_cast<std::uint64_t>(x * x + y * y + z * z);
  }

private:
  static constexpr std::size_t width = 256; // of a face, squares
  static constexpr std::size_t last = width - 1;
  static constexpr double farthest = 0x1p28; // voxels, of the sensor from the grid
  static constexpr float unseen = std::numeric_limits<float>::infinity();

  struct Direction {
    std::size_t face;
    std::size_t row;
    std::size_t column;
    float depth;
  };

  std::optional<Direction>
  directionOf(std::uint64_t key) const
  {
    const io::VoxelPosition at = io::voxelPosition(key);
    const std::array<float, 3> from_sensor = {static_cast<float>(at.x) - position_[0],
                                              static_cast<float>(at.y) - position_[1],
                                              static_cast<float>(at.z) - position_[2]};
    std::size_t axis = 0;
    for (const std::size_t other : {std::size_t{1}, std::size_t{2}})
      if (std::fabs(from_sensor[other]) > std::fabs(from_sensor[axis]))
        axis = other;
    const float depth = std::fabs(from_sensor[axis]);
    if (depth < 1.0f)
      return std::nullopt;
    // -1..1 -> squares
    const auto square = [depth](float across) {
      return std::min(static_cast<std::size_t>((across / depth + 1.0f) * 128.0f), last);
    };
    return Direction{2 * axis + (from_sensor[axis] < 0.0f ? 1 : 0),
                     square(from_sensor[(axis + 1) % 3]),
                     square(from_sensor[(axis + 2) % 3]),
                     depth};
  }

  float&
  depthAt(std::size_t face, std::size_t row, std::size_t column)
  {
    if (faces_[face].empty())
      faces_[face].assign(width * width, unseen);
    return faces_[face][row * width + column];
  }

  void
  clear()
  {
    for (float* square : squares_)
      *square = unseen;
    squares_.clear();
  }

  std::array<float, 3> position_{};         // of the sensor, voxels from that of key 0
  std::array<std::int64_t, 3> nearest_{};   // the same, rounded
  std::array<std::vector<float>, 6> faces_; // empty until a voxel is seen there
  std::vector<float*> squares_;             // of the voxels
};

} // namespace PCL_EXT_ABI
} // namespace pcl_ext
