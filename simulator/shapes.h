// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The solids that the robot cell is built of, and how a ray meets them.
 */
#pragma once

#include <Eigen/Geometry>

#include <cstdint>
#include <variant>
#include <vector>

namespace pcl_ext {
namespace cell {

constexpr double pi = 3.14159265358979323846;

/** \brief What a surface is made of, as far as its reflection at 860 nm goes. */
enum class Material : std::uint8_t {
  Concrete,
  Plaster,
  PaintedSteel,
  BareSteel,
  DarkPlastic,
  Cardboard,
  Cloth
};

/** \brief Share of the light that a surface scatters back when hit head-on, 0..1.
 *
 * Free parameters: ordinary values for matt surfaces. Bare steel and dark plastic are
 * low because they reflect specularly or absorb the light, so that depth cameras do not
 * detect them.
 */
double
reflectivity(Material material);

/** \brief A solid box. */
struct Box {
  Eigen::Isometry3d pose;       ///< box frame -> world; the origin is the box's centre
  Eigen::Vector3d half_extents; ///< metres
  Material material;
};

/** \brief All points within `radius` of the line from `from` to `to`; a sphere where
 * the two coincide. */
struct Capsule {
  Eigen::Vector3d from; ///< world, metres
  Eigen::Vector3d to;   ///< world, metres
  double radius;        ///< metres
  Material material;
};

using Solid = std::variant<Box, Capsule>;
using Solids = std::vector<Solid>;

/** \brief A box that stands upright.
 * \param[in] centre world, metres
 * \param[in] size full edge lengths, metres
 * \param[in] yaw rotation about the vertical, radians
 */
Box
uprightBox(const Eigen::Vector3d& centre,
           const Eigen::Vector3d& size,
           Material material,
           double yaw = 0.0);

/** \brief Where a ray first enters a solid. */
struct Hit {
  double depth = 0.0;         ///< along the sensor's optical axis, metres; 0: no hit
  double cos_incidence = 1.0; ///< cosine between the ray and the surface normal, 0..1
};

/** \brief Part of the image plane at depth 1, x to the right and y down. */
struct ImageBounds {
  double min_x, max_x, min_y, max_y;
};

/** \brief A box moved into a sensor's frame, prepared for many rays from its origin. */
class BoxTarget {
public:
  BoxTarget(const Box& box, const Eigen::Isometry3d& world_to_sensor);

  /** \brief First hit of the ray through (x, y, 1). */
  Hit
  meet(double x, double y) const;

  /** \brief Bounds that hold the box's image; false where it is behind the sensor. */
  bool
  imageBounds(ImageBounds& bounds) const;

private:
  Eigen::Matrix3d sensor_to_box_;
  Eigen::Vector3d ray_origin_; ///< the sensor, in the box's frame
  Eigen::Vector3d half_extents_;
  Eigen::Isometry3d box_to_sensor_;
};

/** \brief A capsule moved into a sensor's frame, prepared for many rays from its
 * origin. */
class CapsuleTarget {
public:
  CapsuleTarget(const Capsule& capsule, const Eigen::Isometry3d& world_to_sensor);

  /** \brief First hit of the ray through (x, y, 1). */
  Hit
  meet(double x, double y) const;

  /** \brief Bounds that hold the capsule's image; false where it is behind the
   * sensor. */
  bool
  imageBounds(ImageBounds& bounds) const;

private:
  double
  meetSphere(const Eigen::Vector3d& ray, const Eigen::Vector3d& centre) const;

  Eigen::Vector3d from_;
  Eigen::Vector3d to_;
  double radius_;
  Eigen::Vector3d axis_; ///< unit vector from `from_` to `to_`, zero for a sphere
  double length_;
};

} // namespace cell
} // namespace pcl_ext
