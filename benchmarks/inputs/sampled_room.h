#pragma once

#include "measuring/workload.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief A 10 x 10 x 4 m room with furniture, seen by a sensor with any number of
 * points.
 *
 * All surfaces are visible and equally dense. The sensor's rays are the same in every
 * frame; their noise is not, and one box in twelve moves. A frame depends on the seed,
 * the number of points and the frame's number alone.
 */
class SampledRoom {
public:
  /** \param[in] points of each frame, all of them finite
   * \param[in] seed of rays and noise
   */
  explicit SampledRoom(std::size_t points, std::uint32_t seed = 1);

  /** \brief Where the sensor stands, its frame -> room, metres. */
  static Eigen::Isometry3d
  sensorPose();

  /** \brief Takes one frame, in the sensor's frame. */
  void
  capture(std::uint32_t frame, pcl::PointCloud<pcl::PointXYZ>& cloud) const;

private:
  /** \brief A parallelogram in the room, metres. */
  struct Surface {
    Eigen::Vector3d corner;
    Eigen::Vector3d first_edge;
    Eigen::Vector3d second_edge;
    bool moves;
  };

  void
  addBox(const Eigen::Vector3d& min, const Eigen::Vector3d& size, bool moves);

  std::size_t points_;
  std::uint32_t seed_;
  std::vector<Surface> surfaces_;
  std::vector<double> areas_;
};

/** \brief A stream of the sampled room, uncropped. */
InputStream
openRoomStream(std::size_t points, std::size_t frames);

} // namespace measuring
} // namespace pcl_ext
