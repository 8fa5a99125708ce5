// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/live_session.h"

#include <boost/asio/buffer.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>

#include <array>
#include <exception>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::view {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;

using beast::error_code;

namespace {

/** \brief Largest message of a viewer, bytes. */
constexpr std::size_t max_message_bytes = 1024;

/** \brief The system's buffer for one viewer, bytes. What is in it cannot be skipped
 * for a slow viewer any more. */
constexpr int send_buffer_bytes = 1 << 18;

} // namespace

/** \brief A viewer's connection. */
class LiveSession : public std::enable_shared_from_this<LiveSession> {
public:
  LiveSession(beast::tcp_stream stream, ServedContent& content, ConnectionToken token)
  : content_(content), token_(std::move(token)), socket_(std::move(stream))
  {}

  ~LiveSession()
  {
    content_.viewers.erase(this);
    if (queue_)
      content_.streams.removeViewer(queue_);
  }

  LiveSession(const LiveSession&) = delete;
  LiveSession&
  operator=(const LiveSession&) = delete;

  void
  run(const http::request<http::empty_body>& request)
  {
    beast::tcp_stream& stream = beast::get_lowest_layer(socket_);
    stream.expires_never(); // the WebSocket has timeouts of its own
    error_code ignored;
    stream.socket().set_option(asio::ip::tcp::no_delay(true), ignored);
    stream.socket().set_option(asio::socket_base::send_buffer_size(send_buffer_bytes),
                               ignored);
    websocket::stream_base::timeout timeout{};
    timeout.handshake_timeout = content_.limits.header_timeout;
    timeout.idle_timeout = content_.limits.idle_timeout;
    timeout.keep_alive_pings = true;
    socket_.set_option(timeout);
    if (request.count(http::field::sec_websocket_protocol) > 0)
      socket_.set_option(
          websocket::stream_base::decorator([](websocket::response_type& response) {
            response.set(http::field::sec_websocket_protocol, live_protocol);
          }));
    socket_.read_message_max(max_message_bytes);
    socket_.auto_fragment(false);
    socket_.async_accept(request, [self = shared_from_this()](error_code error) {
      if (!error)
        self->begin();
    });
  }

  void
  wake()
  {
    if (!is_writing_)
      write();
  }

private:
  using Buffers = std::array<asio::const_buffer, 2>;

  void
  begin()
  {
    queue_ = content_.streams.addViewer();
    content_.viewers.insert(this);
    write();
    read();
  }

  void
  write()
  {
    is_writing_ = content_.streams.next(*queue_, message_);
    if (!is_writing_) {
      content_.check_i_frame_requests();
      return;
    }
    try {
      send();
    }
    catch (const std::exception&) {
      close(); // no memory
    }
  }

  void
  send()
  {
    auto done = [self = shared_from_this()](error_code error, std::size_t) {
      if (!error)
        self->write();
    };
    socket_.text(message_.text != nullptr);
    socket_.async_write(message_.text ? Buffers{asio::buffer(*message_.text)}
                                      : Buffers{asio::buffer(message_.head),
                                                asio::buffer(*message_.frame)},
                        std::move(done));
  }

  void
  read()
  {
    socket_.async_read(buffer_,
                       [self = shared_from_this()](error_code error, std::size_t) {
                         if (error)
                           self->close();
                         else
                           self->take();
                       });
  }

  void
  take()
  {
    if (socket_.got_text())
      if (const auto stream =
              requestedIFrame(beast::buffers_to_string(buffer_.data()))) {
        content_.streams.restart(*queue_, *stream);
        wake();
        content_.check_i_frame_requests();
      }
    buffer_.consume(buffer_.size());
    read();
  }

  /** \brief Ends a write that waits for the viewer. */
  void
  close()
  {
    beast::get_lowest_layer(socket_).close();
  }

  ServedContent& content_;
  ConnectionToken token_;
  websocket::stream<beast::tcp_stream, false> socket_;
  std::shared_ptr<ViewerQueue> queue_; // null before begin()
  beast::flat_buffer buffer_{max_message_bytes};
  OutgoingMessage message_; // that is being sent
  bool is_writing_ = false;
};

void
serveViewer(beast::tcp_stream stream,
            const http::request<http::empty_body>& request,
            ServedContent& content,
            ConnectionToken token)
{
  std::make_shared<LiveSession>(std::move(stream), content, std::move(token))
      ->run(request);
}

void
wake(LiveSession& viewer)
{
  viewer.wake();
}

} // namespace pcl_ext::PCL_EXT_ABI::view
