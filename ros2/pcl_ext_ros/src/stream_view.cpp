#include "stream_view.h"

#include <pcl_ext/view/view_server.h>

#include <fstream>
#include <iterator>
#include <stdexcept>

namespace pcl_ext_ros {

using pcl_ext::nodes::valueOf;

namespace {

std::string
pageOf(const std::string& parameter)
{
  const std::string path = parameter.empty() ? PCL_EXT_ROS_VIEW_PAGE : parameter;
  std::ifstream file(path, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(file),
                      std::istreambuf_iterator<char>()};
  if (!file || content.empty())
    throw std::runtime_error("view_page is '" + path +
                             "'; it must be the viewer's page, viewer.html, which "
                             "viewer/build.sh of pcl_ext makes");
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
  settings.page = pageOf(valueOf<std::string>(parameters, "view_page"));
  settings.name = "ROS";
  settings.request_i_frame = request_i_frame;
  settings.metrics = metrics;
  return settings;
}

void
check(const pcl_ext::view::ViewServerStatus& status)
{
  if (!status.ok())
    throw std::runtime_error("view_port and view_address: " + status.message());
}

} // namespace

class StreamView::Implementation {
public:
  explicit Implementation(const pcl_ext::view::ViewServerSettings& settings)
  : server(settings)
  {}

  pcl_ext::view::ViewServer server;
};

StreamView::StreamView(const pcl_ext::nodes::ParameterValues& parameters,
                       const std::vector<std::string>& topics,
                       const std::function<void(std::size_t)>& request_i_frame,
                       const std::function<std::string()>& metrics)
: implementation_(std::make_unique<Implementation>(
      settingsOf(parameters, request_i_frame, metrics)))
{
  std::size_t number = 0;
  for (const std::string& topic : topics)
    check(implementation_->server.addStream(topic, {}, number));
  check(implementation_->server.start());
}

StreamView::~StreamView() = default;

void
StreamView::show(std::size_t stream,
                 pcl_ext::nodes::Time stamp,
                 const std::vector<std::uint8_t>& frame)
{
  // What cannot be shown cannot be decoded either, which the node reports.
  implementation_->server.publish(stream, stamp, frame);
}

std::string
StreamView::url() const
{
  return implementation_->server.url();
}

bool
StreamView::isLoopback() const
{
  return implementation_->server.isLoopback();
}

} // namespace pcl_ext_ros
