#include "inputs/sampled_room.h"

#include <pcl/conversions.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_01.hpp>

#include <cmath>
#include <numeric>
#include <optional>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief Noise across a surface, metres: a time-of-flight camera's at 2 m. */
constexpr double noise_deviation = 0.002;

/** \brief Movement of the moving box in a frame, metres: 1 m/s at 20 frames a
 * second. */
constexpr double movement_per_frame = 0.05;
constexpr std::uint32_t frames_of_movement = 40;

/** \brief Corner of the room, metres. Off the grid: a wall on voxel faces would fill
 * the voxels of both sides. */
const Eigen::Vector3d room_corner(0.0131, 0.0137, 0.0127);

class RoomSequence : public clouds::CloudSequence {
public:
  RoomSequence(std::size_t points, std::size_t frames)
  : clouds::CloudSequence("room_" + std::to_string(points))
  , frames_(frames)
  , room_(points)
  {}

  std::size_t
  size() const override
  {
    return frames_;
  }

  Eigen::Isometry3d
  sensorPose() const override
  {
    return SampledRoom::sensorPose();
  }

  void
  read(std::size_t index, pcl::PCLPointCloud2& cloud) override
  {
    PositionCloud points;
    room_.capture(static_cast<std::uint32_t>(index), points);
    pcl::toPCLPointCloud2(points, cloud);
  }

private:
  std::size_t frames_;
  SampledRoom room_;
};

} // namespace

SampledRoom::SampledRoom(std::size_t points, std::uint32_t seed)
: points_(points), seed_(seed)
{
  addBox({0.0, 0.0, 0.0}, {10.0, 10.0, 4.0}, false);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) {
      const bool moves = row == 1 && column == 1;
      const double height = 0.5 + 0.15 * row + 0.25 * column;
      addBox({1.0 + 2.2 * column, 1.5 + 2.7 * row, 0.0},
             {0.8, 0.6 + 0.2 * row, height},
             moves);
    }
}

void
SampledRoom::addBox(const Eigen::Vector3d& min, const Eigen::Vector3d& size, bool moves)
{
  for (int axis = 0; axis < 3; ++axis) {
    const int first = (axis + 1) % 3;
    const int second = (axis + 2) % 3;
    for (const double side : {0.0, size[axis]}) {
      Surface surface{
          room_corner + min, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), moves};
      surface.corner[axis] += side;
      surface.first_edge[first] = size[first];
      surface.second_edge[second] = size[second];
      surfaces_.push_back(surface);
      areas_.push_back(size[first] * size[second]);
    }
  }
}

Eigen::Isometry3d
SampledRoom::sensorPose()
{
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(Eigen::Vector3d(5.0, 5.0, 3.9));
  pose.rotate(Eigen::AngleAxisd(2.5, Eigen::Vector3d(1.0, 0.2, 0.1).normalized()));
  return pose;
}

void
SampledRoom::capture(std::uint32_t frame, pcl::PointCloud<pcl::PointXYZ>& cloud) const
{
  boost::random::mt19937 errors(seed_ + 1000003u * (frame + 1u));
  boost::random::normal_distribution<double> noise(0.0, noise_deviation);
  // Its generator restarts with each frame: all frames have the same rays.
  boost::random::mt19937 rays(seed_);
  boost::random::uniform_01<double> jitter;
  const Eigen::Isometry3d room_to_sensor = sensorPose().inverse();
  const double moved = movement_per_frame * (frame % frames_of_movement);
  const double points_per_area =
      static_cast<double>(points_) / std::accumulate(areas_.begin(), areas_.end(), 0.0);

  cloud.resize(points_);
  std::size_t index = 0;
  double area_so_far = 0.0;
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    const Surface& surface = surfaces_[i];
    area_so_far += areas_[i];
    const std::size_t end =
        i + 1 == surfaces_.size()
            ? points_
            : static_cast<std::size_t>(area_so_far * points_per_area);
    const double rows =
        std::ceil(surface.second_edge.norm() * std::sqrt(points_per_area));
    const double columns = std::ceil(static_cast<double>(end - index) / rows);
    const Eigen::Vector3d normal =
        surface.first_edge.cross(surface.second_edge).normalized();
    // Row by row, as sensors scan.
    for (std::size_t k = 0; index < end; ++k, ++index) {
      const double row = std::floor(static_cast<double>(k) / columns);
      const double column = static_cast<double>(k) - row * columns;
      const double first_share = (column + jitter(rays)) / columns;
      const double second_share = (row + jitter(rays)) / rows;
      Eigen::Vector3d position = surface.corner + first_share * surface.first_edge +
                                 second_share * surface.second_edge +
                                 noise(errors) * normal;
      if (surface.moves)
        position.y() += moved;
      cloud[index].getVector3fMap() = (room_to_sensor * position).cast<float>();
    }
  }
  cloud.is_dense = true;
}

InputStream
openRoomStream(std::size_t points, std::size_t frames)
{
  return {std::make_unique<RoomSequence>(points, frames), std::nullopt};
}

} // namespace measuring
} // namespace pcl_ext
