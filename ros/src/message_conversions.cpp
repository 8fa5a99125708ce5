#include "message_conversions.h"

#include <pcl_ext/nodes/cloud_messages.h>

#include <limits>

namespace pcl_ext_ros1 {

pcl_ext::nodes::Time
toNodeTime(const ros::Time& time)
{
  return std::chrono::seconds(time.sec) + std::chrono::nanoseconds(time.nsec);
}

ros::Time
toRosTime(pcl_ext::nodes::Time time)
{
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(time);
  if (time.count() < 0 || seconds.count() > std::numeric_limits<std::uint32_t>::max())
    return {};
  return {static_cast<std::uint32_t>(seconds.count()),
          static_cast<std::uint32_t>((time - seconds).count())};
}

pcl_ext::nodes::Time
rosTimeNow()
{
  return toNodeTime(ros::Time::now());
}

sensor_msgs::PointCloud2
toMessage(const std_msgs::Header& header, const pcl_ext::io::VoxelFrame& frame)
{
  sensor_msgs::PointCloud2 message;
  message.header = header;
  pcl_ext::nodes::writeVoxels(frame, message);
  return message;
}

} // namespace pcl_ext_ros1
