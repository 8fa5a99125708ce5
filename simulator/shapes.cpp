// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_ext {
namespace cell {

namespace {

/** \brief Least depth of a hit; no depth is divided by 0. */
constexpr double nearest_depth = 0.05; // metres

constexpr ImageBounds whole_plane = {-1e9, 1e9, -1e9, 1e9};

void
include(ImageBounds& bounds, double x, double y)
{
  bounds.min_x = std::min(bounds.min_x, x);
  bounds.max_x = std::max(bounds.max_x, x);
  bounds.min_y = std::min(bounds.min_y, y);
  bounds.max_y = std::max(bounds.max_y, y);
}

/** \brief Cosine of the angle between the ray and a unit normal. */
double
cosine(const Eigen::Vector3d& ray, const Eigen::Vector3d& normal)
{
  return std::min(1.0, std::abs(ray.dot(normal)) / ray.norm());
}

} // namespace

double
reflectivity(Material material)
{
  switch (material) {
  case Material::Concrete:
    return 0.35;
  case Material::Plaster:
    return 0.75;
  case Material::PaintedSteel:
    return 0.60;
  case Material::BareSteel:
    return 0.25;
  case Material::DarkPlastic:
    return 0.10;
  case Material::Cardboard:
    return 0.50;
  case Material::Cloth:
    return 0.40;
  }
  return 0.0;
}

Box
uprightBox(const Eigen::Vector3d& centre,
           const Eigen::Vector3d& size,
           Material material,
           double yaw)
{
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(centre);
  pose.rotate(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  return Box{pose, size / 2.0, material};
}

BoxTarget::BoxTarget(const Box& box, const Eigen::Isometry3d& world_to_sensor)
: half_extents_(box.half_extents), box_to_sensor_(world_to_sensor * box.pose)
{
  sensor_to_box_ = box_to_sensor_.linear().transpose();
  ray_origin_ = -(sensor_to_box_ * box_to_sensor_.translation());
}

Hit
BoxTarget::meet(double x, double y) const
{
  const Eigen::Vector3d ray(x, y, 1.0);
  const Eigen::Vector3d direction = sensor_to_box_ * ray;
  double entry = -std::numeric_limits<double>::infinity();
  double exit = std::numeric_limits<double>::infinity();
  int entry_axis = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double inverse = 1.0 / direction[axis];
    const double one = (-half_extents_[axis] - ray_origin_[axis]) * inverse;
    const double other = (half_extents_[axis] - ray_origin_[axis]) * inverse;
    const double near_face = std::min(one, other);
    if (near_face > entry) {
      entry = near_face;
      entry_axis = axis;
    }
    exit = std::min(exit, std::max(one, other));
  }
  Hit hit;
  if (entry > exit || entry < nearest_depth)
    return hit;
  hit.depth = entry; // the ray's third component is 1, so its parameter is the depth
  hit.cos_incidence = std::min(1.0, std::abs(direction[entry_axis]) / ray.norm());
  return hit;
}

bool
BoxTarget::imageBounds(ImageBounds& bounds) const
{
  bounds = {1e9, -1e9, 1e9, -1e9};
  int behind = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d sign(
        corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0, corner & 4 ? 1.0 : -1.0);
    const Eigen::Vector3d point = box_to_sensor_ * half_extents_.cwiseProduct(sign);
    if (point.z() < nearest_depth)
      ++behind;
    else
      include(bounds, point.x() / point.z(), point.y() / point.z());
  }
  if (behind == 8)
    return false;
  // A box that reaches behind the sensor has no bounded image.
  if (behind > 0)
    bounds = whole_plane;
  return true;
}

CapsuleTarget::CapsuleTarget(const Capsule& capsule,
                             const Eigen::Isometry3d& world_to_sensor)
: from_(world_to_sensor * capsule.from)
, to_(world_to_sensor * capsule.to)
, radius_(capsule.radius)
, axis_(Eigen::Vector3d::Zero())
, length_((to_ - from_).norm())
{
  if (length_ > 1e-9)
    axis_ = (to_ - from_) / length_;
}

double
CapsuleTarget::meetSphere(const Eigen::Vector3d& ray,
                          const Eigen::Vector3d& centre) const
{
  const double a = ray.squaredNorm();
  const double b = ray.dot(centre);
  const double discriminant = b * b - a * (centre.squaredNorm() - radius_ * radius_);
  if (discriminant < 0.0)
    return 0.0;
  return (b - std::sqrt(discriminant)) / a;
}

Hit
CapsuleTarget::meet(double x, double y) const
{
  const Eigen::Vector3d ray(x, y, 1.0);
  Hit hit;
  // The infinite cylinder first: most rays hit its lateral surface.
  const Eigen::Vector3d across = ray - ray.dot(axis_) * axis_;
  const Eigen::Vector3d from_across = from_ - from_.dot(axis_) * axis_;
  const double a = across.squaredNorm();
  const double b = across.dot(from_across);
  const double discriminant =
      b * b - a * (from_across.squaredNorm() - radius_ * radius_);
  if (discriminant < 0.0)
    return hit;
  double depth = a > 0.0 ? (b - std::sqrt(discriminant)) / a : 0.0;
  const double along = (depth * ray - from_).dot(axis_);
  Eigen::Vector3d centre = from_ + along * axis_;
  if (length_ == 0.0 || along < 0.0 || along > length_) {
    centre = along > length_ && length_ > 0.0 ? to_ : from_;
    depth = meetSphere(ray, centre);
  }
  if (depth < nearest_depth)
    return hit;
  hit.depth = depth;
  hit.cos_incidence = cosine(ray, (depth * ray - centre) / radius_);
  return hit;
}

bool
CapsuleTarget::imageBounds(ImageBounds& bounds) const
{
  if (std::max(from_.z(), to_.z()) + radius_ < nearest_depth)
    return false;
  if (std::min(from_.z(), to_.z()) - radius_ < nearest_depth) {
    bounds = whole_plane;
    return true;
  }
  // The image of the cube around each end sphere; the hull of both holds the capsule.
  bounds = {1e9, -1e9, 1e9, -1e9};
  for (const Eigen::Vector3d& end : {from_, to_})
    for (const double side : {-radius_, radius_})
      for (const double z : {end.z() - radius_, end.z() + radius_})
        include(bounds, (end.x() + side) / z, (end.y() + side) / z);
  return true;
}

} // namespace cell
} // namespace pcl_ext
