// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/byte_ranges.h"
#include "view/connections.h"
#include "view/live_session.h"
#include "view/request_answer.h"

#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/serializer.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include <algorithm>
#include <optional>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::view {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;

using beast::error_code;

namespace {

/** \brief Longest head of a request, bytes. */
constexpr std::uint32_t max_head_bytes = 8192;

/** \brief Bytes of a file that are read at a time. */
constexpr std::size_t piece_bytes = std::size_t{1} << 17;

/** \brief A connection that sends requests. */
class HttpSession : public std::enable_shared_from_this<HttpSession> {
public:
  HttpSession(asio::ip::tcp::socket socket,
              ServedContent& content,
              ConnectionToken token)
  : content_(content), token_(std::move(token)), stream_(std::move(socket))
  {}

  /** \brief Waits for a request.
   * \param[in] time in which it must have arrived
   */
  void
  read(std::chrono::milliseconds time)
  {
    parser_.emplace();
    parser_->header_limit(max_head_bytes);
    stream_.expires_after(time);
    http::async_read_header(stream_,
                            buffer_,
                            *parser_,
                            [self = shared_from_this()](error_code error, std::size_t) {
                              self->take(error);
                            });
  }

private:
  void
  take(error_code error)
  {
    if (error == http::error::end_of_stream)
      return close();
    if (error == http::error::header_limit)
      return send(errorAnswer(http::status::request_header_fields_too_large,
                              "the head of the request is too long"));
    if (error && error.category() == error_code(http::error::bad_target).category())
      return send(errorAnswer(http::status::bad_request, "this is no request of HTTP"));
    if (error)
      return; // too slow, or gone
    const Request& request = parser_->get();
    std::optional<Answer> refusal = refuse(request, content_.is_loopback);
    if (!refusal && (parser_->chunked() || parser_->content_length().value_or(0) > 0))
      refusal = errorAnswer(http::status::bad_request, "a request has no content here");
    if (!refusal && beast::websocket::is_upgrade(request)) {
      refusal = refuseViewer(request, content_.is_live);
      if (!refusal)
        return serveViewer(std::move(stream_), request, content_, std::move(token_));
    }
    Answer answer = refusal ? std::move(*refusal)
                    : asksForMetrics(request)
                        ? metricsAnswer(request, content_.metrics())
                        : answerOf(request, content_.resources, content_.random());
    if (request.method() == http::verb::head)
      answer.parts.clear();
    send(std::move(answer));
  }

  void
  send(Answer answer)
  {
    answer_ = std::move(answer);
    part_ = 0;
    serializer_.emplace(answer_.head);
    stream_.expires_after(content_.limits.idle_timeout);
    http::async_write_header(
        stream_,
        *serializer_,
        [self = shared_from_this()](error_code error, std::size_t) {
          if (!error)
            self->sendPiece();
        });
  }

  /** \brief Sends the next bytes of the answer's content. */
  void
  sendPiece()
  {
    while (part_ < answer_.parts.size() && answer_.parts[part_].size == 0)
      ++part_;
    if (part_ == answer_.parts.size())
      return answer_.head.keep_alive() ? read(content_.limits.idle_timeout) : close();
    AnswerPart& part = answer_.parts[part_];
    piece_.resize(
        static_cast<std::size_t>(std::min<std::uint64_t>(part.size, piece_bytes)));
    if (!part.resource->read(part.offset, piece_.size(), piece_.data()))
      return; // the file has become shorter: the receiver notices missing bytes
    part.offset += piece_.size();
    part.size -= piece_.size();
    stream_.expires_after(content_.limits.idle_timeout);
    asio::async_write(stream_,
                      asio::buffer(piece_),
                      [self = shared_from_this()](error_code error, std::size_t) {
                        if (!error)
                          self->sendPiece();
                      });
  }

  void
  close()
  {
    error_code ignored;
    stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
  }

  ServedContent& content_;
  ConnectionToken token_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{max_head_bytes + 1024};
  std::optional<http::request_parser<http::empty_body>> parser_;
  Answer answer_;
  std::optional<http::response_serializer<http::empty_body>> serializer_;
  std::size_t part_ = 0; // of the answer, that is being sent
  std::vector<char> piece_;
};

} // namespace

void
serveConnection(asio::ip::tcp::socket socket,
                ServedContent& content,
                ConnectionToken token)
{
  const auto session =
      std::make_shared<HttpSession>(std::move(socket), content, std::move(token));
  session->read(content.limits.header_timeout);
}

} // namespace pcl_ext::PCL_EXT_ABI::view
