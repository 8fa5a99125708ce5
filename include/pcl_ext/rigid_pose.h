#pragma once

#include <Eigen/Geometry>

namespace pcl_ext {

/** \brief A pose in the world: the frame of a sensor -> the global frame, metres; takes an
 * Eigen::Isometry3d. Not aligned, so that it looks the same to the library and to programs
 * built with other vector instructions. */
using WorldPose = Eigen::Transform<double, 3, Eigen::Isometry, Eigen::DontAlign>;

/** \brief True if a pose is what it says: a rotation and a translation, all finite. */
inline bool
isRigid(const Eigen::Isometry3f& pose)
{
  const Eigen::Matrix3f rotation = pose.linear();
  // NaN fails the comparisons, too.
  return (rotation * rotation.transpose() - Eigen::Matrix3f::Identity()).norm() <
             1e-3f &&
         rotation.determinant() > 0.0f && pose.translation().allFinite();
}

} // namespace pcl_ext
