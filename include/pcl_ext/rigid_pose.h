#pragma once

#include <Eigen/Geometry>

namespace pcl_ext {

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
