// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/view/view_server.h>

#include "view/connections.h"
#include "view/listeners.h"
#include "view/live_messages.h"
#include "view/server_metrics.h"

#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>

#include <csignal>
#include <filesystem>
#include <new>
#include <thread>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::view {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

constexpr std::chrono::milliseconds wait_after_failed_accept{100};
constexpr std::chrono::seconds state_interval{1}; // doc/viewing.md

constexpr char too_many_connections[] = "HTTP/1.1 503 Service Unavailable\r\n"
                                        "Content-Type: text/plain\r\n"
                                        "Content-Length: 23\r\n"
                                        "Retry-After: 5\r\n"
                                        "Connection: close\r\n\r\n"
                                        "there are many viewers\n";

/** \brief Calls a function; exceptions become a status. */
template <typename FunctionT>
ViewServerStatus
guarded(const FunctionT& function) noexcept
{
  try {
    return function();
  }
  catch (const std::bad_alloc&) {
    return outOfMemoryStatus<ViewServerStatus>();
  }
  catch (const std::exception& error) {
    try {
      return {ViewServerCode::InputFailed, error.what()};
    }
    catch (const std::bad_alloc&) {
      return outOfMemoryStatus<ViewServerStatus>();
    }
  }
}

} // namespace

class ViewServer::Implementation {
public:
  explicit Implementation(const ViewServerSettings& settings)
  : settings_(settings), content_(settings)
  {
    content_.resources["/"] = textResource("text/html; charset=utf-8", settings.page);
    addSource(liveSource(settings.name));
    content_.check_i_frame_requests = [this] { requestIFrames(); };
    content_.metrics = [this] {
      return (settings_.metrics ? settings_.metrics() : std::string()) +
             metricsOf(statistics());
    };
  }

  ~Implementation()
  {
    io_.stop();
    if (thread_.joinable())
      thread_.join();
  }

  Implementation(const Implementation&) = delete;
  Implementation&
  operator=(const Implementation&) = delete;

  ViewServerStatus
  setRecording(const std::vector<std::string>& paths)
  {
    if (thread_.joinable())
      return {ViewServerCode::InvalidArgument, "the server has started already"};
    std::vector<ListedFile> files;
    for (std::size_t i = 0; i < paths.size(); ++i) {
      const auto resource = fileResource("application/octet-stream", paths[i]);
      const std::string url = "api/files/" + std::to_string(i);
      files.push_back(
          {std::filesystem::path(paths[i]).filename().string(), url, resource->size()});
      content_.resources["/" + url] = resource;
    }
    content_.is_live = false;
    addSource(recordingSource(settings_.name, files));
    return {};
  }

  ViewServerStatus
  start()
  {
    if (thread_.joinable())
      return {ViewServerCode::InvalidArgument, "the server has started already"};
    ViewServerStatus status =
        listen(io_, settings_.address, settings_.port, listeners_);
    if (!status.ok())
      return status;
    content_.is_loopback = listeners_.is_loopback;
    const tcp::endpoint endpoint = listeners_.acceptors.front().local_endpoint();
    url_ = "http://" + hostOfUrl(endpoint.address()) + ":" +
           std::to_string(endpoint.port()) + "/";
    for (tcp::acceptor& acceptor : listeners_.acceptors)
      accept(acceptor);
    if (content_.is_live)
      sendStates();
    // Signals are for the program's own threads.
    sigset_t all;
    sigset_t before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    try {
      thread_ = std::thread([this] { run(); });
    }
    catch (const std::system_error& error) {
      status = {ViewServerCode::OutOfMemory,
                std::string("cannot start a thread: ") + error.what()};
    }
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    return status;
  }

  std::uint16_t
  port() const
  {
    return listeners_.port;
  }

  std::string
  url() const
  {
    return url_;
  }

  bool
  isLoopback() const
  {
    return listeners_.is_loopback;
  }

  LiveStreams&
  streams()
  {
    return content_.streams;
  }

  /** \brief Makes the server's thread send what waits. Called by any thread. */
  void
  wake()
  {
    if (is_waking_.exchange(true))
      return;
    try {
      asio::post(io_, [this] {
        is_waking_ = false;
        for (LiveSession* const viewer : content_.viewers)
          view::wake(*viewer);
        requestIFrames();
      });
    }
    catch (...) {
      is_waking_ = false;
      throw;
    }
  }

  ViewServerStatistics
  statistics() const
  {
    ViewServerStatistics statistics;
    statistics.connections = content_.connections;
    statistics.refused = refused_;
    content_.streams.addTo(statistics);
    return statistics;
  }

private:
  void
  addSource(const std::string& source)
  {
    content_.resources["/api/source.json"] = textResource("application/json", source);
  }

  void
  accept(tcp::acceptor& acceptor)
  {
    acceptor.async_accept([this, &acceptor](error_code error, tcp::socket socket) {
      if (error == asio::error::operation_aborted)
        return;
      if (!error) {
        try {
          admit(std::move(socket));
        }
        catch (const std::exception&) {
          // As in run().
        }
        accept(acceptor);
        return;
      }
      // Such as that there are no more descriptors.
      accept_timer_.expires_after(wait_after_failed_accept);
      accept_timer_.async_wait([this, &acceptor](error_code) { accept(acceptor); });
    });
  }

  void
  admit(tcp::socket socket)
  {
    closeOnExec(socket.native_handle());
    if (content_.connections < content_.limits.max_connections) {
      serveConnection(std::move(socket),
                      content_,
                      std::make_unique<CountedConnection>(content_.connections));
      return;
    }
    ++refused_;
    // The buffer of a new connection has room for it.
    error_code ignored;
    socket.non_blocking(true, ignored);
    socket.write_some(
        asio::buffer(too_many_connections, sizeof(too_many_connections) - 1), ignored);
  }

  void
  requestIFrames()
  {
    for (const std::size_t stream :
         content_.streams.dueIFrameRequests(LiveStreams::Clock::now()))
      settings_.request_i_frame(stream);
    if (is_request_timer_set_ || !content_.streams.wantsIFrames())
      return;
    is_request_timer_set_ = true;
    request_timer_.expires_after(settings_.limits.i_frame_request_interval);
    request_timer_.async_wait([this](error_code) {
      is_request_timer_set_ = false;
      requestIFrames();
    });
  }

  /** \brief Sends viewers how fresh the streams are, from now on once a second. */
  void
  sendStates()
  {
    // First, as what follows may run out of memory.
    state_timer_.expires_after(state_interval);
    state_timer_.async_wait([this](error_code) { sendStates(); });
    content_.streams.queueState();
    for (LiveSession* const viewer : content_.viewers)
      view::wake(*viewer);
  }

  void
  run()
  {
    const auto never_done = asio::make_work_guard(io_);
    while (!io_.stopped())
      try {
        io_.run();
      }
      catch (const std::exception&) {
        // Memory ran out for a connection, which is closed; the others go on.
      }
  }

  const ViewServerSettings settings_;
  ServedContent content_; // before io_, as connections end with io_
  asio::io_context io_{1};
  Listeners listeners_;
  asio::steady_timer accept_timer_{io_};
  asio::steady_timer request_timer_{io_};
  asio::steady_timer state_timer_{io_};
  bool is_request_timer_set_ = false;
  std::atomic<bool> is_waking_{false};
  std::atomic<std::uint64_t> refused_{0};
  std::string url_;
  std::thread thread_;
};

bool
isViewerPage(const std::string& page)
{
  return page.find(R"(id="pcl-ext-codec")") != std::string::npos;
}

ViewServer::ViewServer(const ViewServerSettings& settings)
: implementation_(new Implementation(settings))
{}

ViewServer::~ViewServer() = default;

ViewServerStatus
ViewServer::setRecording(const std::vector<std::string>& paths) noexcept
{
  return guarded([&] { return implementation_->setRecording(paths); });
}

ViewServerStatus
ViewServer::start() noexcept
{
  return guarded([&] { return implementation_->start(); });
}

std::uint16_t
ViewServer::port() const noexcept
{
  return implementation_->port();
}

std::string
ViewServer::url() const
{
  return implementation_->url();
}

bool
ViewServer::isLoopback() const noexcept
{
  return implementation_->isLoopback();
}

ViewServerStatus
ViewServer::addStream(const std::string& name,
                      const std::map<std::string, std::string>& metadata,
                      std::size_t& stream) noexcept
{
  return guarded([&] {
    stream = implementation_->streams().addStream({name, metadata});
    implementation_->wake();
    return ViewServerStatus();
  });
}

ViewServerStatus
ViewServer::setMetadata(std::size_t stream,
                        const std::map<std::string, std::string>& metadata) noexcept
{
  return guarded([&]() -> ViewServerStatus {
    if (!implementation_->streams().setMetadata(stream, metadata))
      return {ViewServerCode::InvalidArgument,
              "there is no stream " + std::to_string(stream)};
    implementation_->wake();
    return {};
  });
}

ViewServerStatus
ViewServer::publish(std::size_t stream,
                    std::chrono::nanoseconds time,
                    std::vector<std::uint8_t> frame) noexcept
{
  return guarded([&] {
    ViewServerStatus status =
        implementation_->streams().publish(stream, time, std::move(frame));
    if (status.ok())
      implementation_->wake();
    return status;
  });
}

void
ViewServer::setProblem(const std::string& problem) noexcept
{
  guarded([&] {
    implementation_->streams().setProblem(problem);
    implementation_->wake();
    return ViewServerStatus();
  });
}

void
ViewServer::end() noexcept
{
  guarded([&] {
    implementation_->streams().end();
    implementation_->wake();
    return ViewServerStatus();
  });
}

ViewServerStatistics
ViewServer::statistics() const noexcept
{
  return implementation_->statistics();
}

} // namespace pcl_ext::PCL_EXT_ABI::view
