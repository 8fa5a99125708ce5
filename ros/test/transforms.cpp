#include "transforms.h"

#include <Eigen/Geometry>

#include <tf2_eigen/tf2_eigen.h>

namespace pcl_ext_ros {
namespace test {

pcl_ext::WorldPose
samplePose(double shift)
{
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(Eigen::Vector3d(0.513 + shift, -0.277, 1.391));
  pose.rotate(
      Eigen::AngleAxisd(0.7 + shift, Eigen::Vector3d(0.2, -0.9, 0.4).normalized()));
  return throughMessage(pcl_ext::WorldPose(pose));
}

geometry_msgs::TransformStamped
toMessage(const std::string& frame_id,
          const pcl_ext::WorldPose& pose,
          const ros::Time& stamp)
{
  geometry_msgs::TransformStamped message =
      tf2::eigenToTransform(Eigen::Isometry3d(pose));
  message.header.stamp = stamp;
  message.header.frame_id = "world";
  message.child_frame_id = frame_id;
  return message;
}

pcl_ext::WorldPose
throughMessage(const pcl_ext::WorldPose& pose)
{
  return pcl_ext::WorldPose(tf2::transformToEigen(toMessage("", pose)));
}

} // namespace test
} // namespace pcl_ext_ros
