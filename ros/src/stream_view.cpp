#include "stream_view.h"

#include "parameter_reader.h"

#include <ros/console.h>

#include <chrono>

namespace pcl_ext_ros {

namespace {

pcl_ext::view::ViewServerSettings
settingsOf(const ViewParameters& parameters,
           const std::function<void(std::size_t)>& request_i_frame)
{
  pcl_ext::view::ViewServerSettings settings;
  settings.address = parameters.address;
  settings.port = parameters.port;
  settings.page = parameters.page;
  settings.name = "ROS";
  settings.request_i_frame = request_i_frame;
  return settings;
}

void
check(const pcl_ext::view::ViewServerStatus& status)
{
  if (!status.ok())
    throw WrongParameter("Parameters ~view_port and ~view_address: " +
                         status.message());
}

} // namespace

StreamView::StreamView(const ViewParameters& parameters,
                       const std::vector<std::string>& topics,
                       const std::function<void(std::size_t)>& request_i_frame)
: server_(settingsOf(parameters, request_i_frame))
{
  std::size_t number = 0;
  for (const std::string& topic : topics)
    check(server_.addStream(topic, {}, number));
  check(server_.start());
  ROS_INFO("The streams are shown at %s", server_.url().c_str());
  if (!server_.isLoopback())
    ROS_WARN("Anyone who can reach this machine can look at the streams");
}

void
StreamView::show(std::size_t stream,
                 const ros::Time& stamp,
                 const std::vector<std::uint8_t>& frame)
{
  // What cannot be shown cannot be decoded either, which the node reports.
  server_.publish(stream, std::chrono::nanoseconds(stamp.toNSec()), frame);
}

} // namespace pcl_ext_ros
