#pragma once

#include <pcl_ext/nodes/stream_health.h>
#include <pcl_ext/rigid_pose.h>

#include <std_msgs/Header.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <optional>
#include <string>

namespace pcl_ext_ros {

/** \brief Where a frame is in the world, and how that is known. */
struct FoundTransform {
  /** \brief The frame -> the global frame, metres; none: TF does not know it. */
  std::optional<pcl_ext::WorldPose> pose;

  /** \brief TF knows none at the stamp, and this is the latest. */
  bool is_latest = false;

  /** \brief Why there is none at the stamp. */
  std::string failure;
};

/** \brief Looks up transforms to the global frame. Listens in a thread of its own. */
class TransformLookup {
public:
  /** \brief Listens from now on.
   * \param[in] global_frame without a slash before it
   * \param[in] timeout how long after its stamp a transform is waited for, seconds
   */
  TransformLookup(std::string global_frame, double timeout);

  /** \brief The transform at a stamp, else the latest, else none; of the global frame
   * itself the identity.
   * \param[in] header stamp and frame
   */
  FoundTransform
  toGlobalFrame(const std_msgs::Header& header) const;

private:
  std::string global_frame_;
  pcl_ext::nodes::Time timeout_;
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_{buffer_};
};

} // namespace pcl_ext_ros
