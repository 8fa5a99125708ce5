// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream_view.h"

#include <pcl_ext/view/view_server.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <mutex>
#include <stdexcept>
#include <utility>

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
  if (!file || !pcl_ext::view::isViewerPage(content))
    throw std::runtime_error("view_page is '" + path +
                             "'; it must be the viewer's page, viewer.html, which "
                             "viewer/build.sh of pcl_ext makes");
  return content;
}

pcl_ext::view::ViewServerSettings
settingsOf(const pcl_ext::nodes::ParameterValues& parameters,
           const std::function<std::string()>& metrics)
{
  pcl_ext::view::ViewServerSettings settings;
  settings.address = valueOf<std::string>(parameters, "view_address");
  settings.port =
      static_cast<std::uint16_t>(valueOf<std::int64_t>(parameters, "view_port"));
  settings.page = pageOf(valueOf<std::string>(parameters, "view_page"));
  settings.name = "ROS";
  settings.metrics = metrics;
  return settings;
}

} // namespace

class StreamView::Implementation {
public:
  Implementation(pcl_ext::view::ViewServerSettings settings,
                 std::function<void(const std::string&)> request_i_frame)
  : server_(withRequests(settings, std::move(request_i_frame)))
  {
    if (const auto status = server_.start(); !status.ok())
      throw std::runtime_error("view_port and view_address: " + status.message());
  }

  void
  show(const std::string& topic,
       pcl_ext::nodes::Time stamp,
       const std::vector<std::uint8_t>& frame)
  {
    // What cannot be shown cannot be decoded either, which the node reports.
    server_.publish(numberOf(topic), stamp, frame);
  }

  const pcl_ext::view::ViewServer&
  server() const
  {
    return server_;
  }

private:
  pcl_ext::view::ViewServerSettings&
  withRequests(pcl_ext::view::ViewServerSettings& settings,
               std::function<void(const std::string&)> request_i_frame)
  {
    settings.request_i_frame = [this, request = std::move(request_i_frame)](
                                   std::size_t number) { request(topicOf(number)); };
    return settings;
  }

  /** \brief The number of a topic, a new one for its first frame. */
  std::size_t
  numberOf(const std::string& topic)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto known = std::find(topics_.begin(), topics_.end(), topic);
    std::size_t number = static_cast<std::size_t>(known - topics_.begin());
    if (known == topics_.end() && server_.addStream(topic, {}, number).ok())
      topics_.push_back(topic);
    return number;
  }

  std::string
  topicOf(std::size_t number)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return topics_.at(number);
  }

  std::mutex mutex_; // guards the topics
  std::vector<std::string> topics_;
  pcl_ext::view::ViewServer server_; // last, as its thread uses the others
};

StreamView::StreamView(const pcl_ext::nodes::ParameterValues& parameters,
                       const std::function<void(const std::string&)>& request_i_frame,
                       const std::function<std::string()>& metrics)
: implementation_(std::make_unique<Implementation>(settingsOf(parameters, metrics),
                                                   request_i_frame))
{}

StreamView::~StreamView() = default;

void
StreamView::show(const std::string& topic,
                 pcl_ext::nodes::Time stamp,
                 const std::vector<std::uint8_t>& frame)
{
  implementation_->show(topic, stamp, frame);
}

std::string
StreamView::url() const
{
  return implementation_->server().url();
}

bool
StreamView::isLoopback() const
{
  return implementation_->server().isLoopback();
}

} // namespace pcl_ext_ros
