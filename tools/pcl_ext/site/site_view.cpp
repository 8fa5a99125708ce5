// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "site/site_view.h"

#include <pcl_ext/view/view_server.h>

#include "console/throw_unless_ok.h"
#include "viewing/started_server.h"
#include "viewing/viewer_page.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace pcl_ext::tools {

namespace {

/** \brief Shows the frames of a site in browsers. */
class SiteView : public FrameTaker {
public:
  using RequestIFrame = std::function<void(const std::string& stream)>;

  SiteView(view::ViewServerSettings settings,
           RequestIFrame request_i_frame,
           bool opens_browser,
           Console& console)
  : request_i_frame_(std::move(request_i_frame))
  , console_(console)
  , server_(withRequests(settings))
  {
    startServer(server_, settings, opens_browser, console);
  }

  void
  take(const link::LinkFrame& frame) override
  {
    auto found = numbers_.find(frame.stream);
    const bool has_changed = metadata_changes_.take(frame);
    if (found == numbers_.end())
      found = numbers_.emplace(frame.stream, addStream(frame)).first;
    else if (has_changed && found->second)
      throwUnlessOk(server_.setMetadata(*found->second, frame.metadata));
    if (found->second)
      throwUnlessOk(server_.publish(*found->second, frame.time, frame.bytes));
  }

  void
  setProblem(const std::string& problem) override
  {
    server_.setProblem(problem);
  }

  void
  finish() override
  {
    server_.end();
  }

  bool
  hasLeftOut() const override
  {
    return std::any_of(numbers_.begin(), numbers_.end(), [](const auto& number) {
      return !number.second;
    });
  }

private:
  /** \return its number in the output; none if it cannot be shown, which is told */
  std::optional<std::size_t>
  addStream(const link::LinkFrame& frame)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::size_t number = 0;
    const auto added = server_.addStream(frame.stream, frame.metadata, number);
    if (!added.ok()) {
      console_.error(frame.stream + ": it is not shown: " + added.message());
      return std::nullopt;
    }
    names_.push_back(frame.stream);
    return number;
  }

  view::ViewServerSettings
  withRequests(view::ViewServerSettings settings)
  {
    settings.request_i_frame = [this](std::size_t stream) { request(stream); };
    return settings;
  }

  void
  request(std::size_t stream)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (stream < names_.size())
      request_i_frame_(names_[stream]);
  }

  const RequestIFrame request_i_frame_;
  Console& console_;
  std::mutex mutex_;               // guards names_
  std::vector<std::string> names_; // of the streams, by their number in the output
  std::map<std::string, std::optional<std::size_t>> numbers_;
  MetadataChanges metadata_changes_;
  // Last, as its thread uses the others.
  view::ViewServer server_;
};

} // namespace

void
addSiteViewOptions(CLI::App& app, SiteViewOptions& options)
{
  CLI::Option* const view =
      app.add_flag("--view", options.is_on, "show the streams in a browser");
  app.add_option("--port", options.port, "of the page (a free one)")
      ->type_name("N")
      ->needs(view);
  app.add_option(
         "--address", options.address, "for others, such as 0.0.0.0 (this machine)")
      ->type_name("ADDRESS")
      ->needs(view);
  app.add_flag_callback(
         "--no-browser",
         [&options] { options.opens_browser = false; },
         "print the page's address alone")
      ->needs(view);
  app.add_option("--page", options.page, "the viewer's HTML (that of the program)")
      ->type_name("FILE")
      ->needs(view);
}

std::unique_ptr<FrameTaker>
makeSiteView(const SiteViewOptions& options,
             const std::string& name,
             std::function<void(const std::string& stream)> request_i_frame,
             std::function<std::string()> metrics,
             Console& console)
{
  view::ViewServerSettings settings;
  settings.page = readPage(options.page);
  settings.address = options.address;
  settings.port = options.port;
  settings.name = name;
  settings.metrics = std::move(metrics);
  return std::make_unique<SiteView>(
      std::move(settings), std::move(request_i_frame), options.opens_browser, console);
}

void
addMetricsOptions(CLI::App& app, MetricsOptions& options)
{
  CLI::Option* const port =
      app.add_option("--metrics-port", options.port, "serve /metrics for Prometheus")
          ->type_name("N");
  app.add_option("--metrics-address",
                 options.address,
                 "for other machines, such as 0.0.0.0 (this machine)")
      ->type_name("ADDRESS")
      ->needs(port);
}

std::shared_ptr<void>
serveMetrics(const MetricsOptions& options,
             std::function<std::string()> metrics,
             Console& console)
{
  if (!options.port)
    return nullptr;
  view::ViewServerSettings settings;
  settings.page =
      "<!DOCTYPE html><title>pcl_ext</title><a href=\"/metrics\">metrics</a>";
  settings.port = *options.port;
  settings.address = options.address;
  settings.metrics = std::move(metrics);
  auto server = std::make_shared<view::ViewServer>(settings);
  throwUnlessOk(server->start());
  console.summary("metrics: " + server->url() + "metrics");
  return server;
}

} // namespace pcl_ext::tools
