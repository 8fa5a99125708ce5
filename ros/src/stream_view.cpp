#include "stream_view.h"

#include "parameter_reader.h"

#include <ros/console.h>

#include <chrono>
#include <fstream>
#include <iterator>

namespace pcl_ext_ros1 {

using pcl_ext::nodes::valueOf;

namespace {

/** \brief The viewer's page.
 * \throws WrongParameter if it cannot be read or is empty
 */
std::string
readPage(const std::string& parameter)
{
  const std::string path = parameter.empty() ? PCL_EXT_ROS1_VIEW_PAGE : parameter;
  std::ifstream file(path, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(file),
                      std::istreambuf_iterator<char>()};
  if (!file || content.empty())
    ParameterReader::refuse("view_page",
                            "'" + path + "'",
                            "the viewer's page, viewer.html, which viewer/build.sh of "
                            "pcl_ext makes");
  return content;
}

pcl_ext::view::ViewServerSettings
settingsOf(const pcl_ext::nodes::ParameterValues& parameters,
           const std::function<void(std::size_t)>& request_i_frame,
           const std::function<std::string()>& metrics)
{
  pcl_ext::view::ViewServerSettings settings;
  settings.address = valueOf<std::string>(parameters, "view_address");
  settings.port =
      static_cast<std::uint16_t>(valueOf<std::int64_t>(parameters, "view_port"));
  settings.page = readPage(valueOf<std::string>(parameters, "view_page"));
  settings.name = "ROS";
  settings.request_i_frame = request_i_frame;
  settings.metrics = metrics;
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

StreamView::StreamView(const pcl_ext::nodes::ParameterValues& parameters,
                       const std::vector<std::string>& topics,
                       const std::function<void(std::size_t)>& request_i_frame,
                       const std::function<std::string()>& metrics)
: server_(settingsOf(parameters, request_i_frame, metrics))
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

} // namespace pcl_ext_ros1
