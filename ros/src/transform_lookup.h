#pragma once

#include <pcl_ext/nodes/stream_health.h>
#include <pcl_ext/rigid_pose.h>

#include <std_msgs/Header.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <optional>
#include <string>

namespace pcl_ext_ros1 {

/** \brief Result of a lookup. */
struct FoundTransform {
  /** \brief Frame -> global frame, metres; nothing if TF has no transform. */
  std::optional<pcl_ext::WorldPose> pose;

  /** \brief TF has none at the stamp; this is the latest. */
  bool is_latest = false;

  /** \brief Why there is none at the stamp. */
  std::string failure;
};

/** \brief Looks up transforms to the global frame. TF messages are received by a
 * separate thread. */
class TransformLookup {
public:
  /** \brief Starts to listen.
   * \param[in] global_frame without a leading slash
   * \param[in] timeout seconds after its stamp for which a transform is waited for
   */
  TransformLookup(std::string global_frame, double timeout);

  /** \brief The transform at a stamp, else the latest, else none. That of the global
   * frame is the identity.
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

} // namespace pcl_ext_ros1
