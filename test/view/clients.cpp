// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/clients.h"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket.hpp>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <sstream>

namespace pcl_ext::PCL_EXT_ABI::view::test {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;

namespace {

constexpr int seconds_to_wait = 60;

std::string
withHost(std::uint16_t port, const std::string& headers)
{
  return headers.find("Host:") != std::string::npos
             ? headers
             : "Host: 127.0.0.1:" + std::to_string(port) + "\r\n" + headers;
}

std::uint64_t
littleEndian(const std::uint8_t* bytes, std::size_t count)
{
  std::uint64_t value = 0;
  for (std::size_t i = count; i-- > 0;)
    value = value << 8 | bytes[i];
  return value;
}

} // namespace

RawConnection::RawConnection(std::uint16_t port)
: socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0))
{
  const timeval timeout{seconds_to_wait, 0};
  ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof(timeout));
  ::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &timeout, sizeof(timeout));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)),
            0)
      << std::strerror(errno);
}

RawConnection::~RawConnection() { ::close(socket_); }

bool
RawConnection::send(const std::string& bytes)
{
  return ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) ==
         static_cast<ssize_t>(bytes.size());
}

std::optional<std::string>
RawConnection::receiveAll()
{
  std::string received;
  char bytes[4096];
  for (;;) {
    const ssize_t count = ::recv(socket_, bytes, sizeof(bytes), 0);
    if (count == 0 || (count < 0 && errno == ECONNRESET))
      return received;
    if (count < 0)
      return std::nullopt;
    received.append(bytes, static_cast<std::size_t>(count));
  }
}

std::string
RawConnection::receiveUntil(const std::string& end)
{
  std::string received;
  while (received.size() < end.size() ||
         received.compare(received.size() - end.size(), end.size(), end) != 0) {
    const std::string one = receive(1);
    if (one.empty())
      break;
    received += one;
  }
  return received;
}

std::string
RawConnection::receive(std::size_t count)
{
  std::string received(count, '\0');
  std::size_t done = 0;
  while (done < count) {
    const ssize_t more = ::recv(socket_, received.data() + done, count - done, 0);
    if (more <= 0)
      break;
    done += static_cast<std::size_t>(more);
  }
  received.resize(done);
  return received;
}

HttpAnswer
request(std::uint16_t port,
        const std::string& target,
        const std::string& headers,
        const std::string& method)
{
  RawConnection connection(port);
  connection.send(method + " " + target + " HTTP/1.1\r\n" + withHost(port, headers) +
                  "\r\n");
  HttpAnswer answer;
  std::istringstream head(connection.receiveUntil("\r\n\r\n"));
  std::string line;
  std::getline(head, line);
  if (line.size() > 12)
    answer.status = std::atoi(line.c_str() + 9);
  while (std::getline(head, line)) {
    const std::size_t colon = line.find(": ");
    if (colon == std::string::npos)
      continue;
    std::string name = line.substr(0, colon);
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char letter) {
      return static_cast<char>(std::tolower(letter));
    });
    answer.headers[name] = line.substr(colon + 2, line.size() - colon - 3);
  }
  if (method != "HEAD" && answer.headers.count("content-length") > 0)
    answer.body = connection.receive(std::stoul(answer.headers["content-length"]));
  return answer;
}

int
upgradeStatus(std::uint16_t port, const std::string& headers, const std::string& path)
{
  return request(port,
                 path,
                 headers + "Connection: Upgrade\r\nUpgrade: websocket\r\n"
                           "Sec-WebSocket-Version: 13\r\n"
                           "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n")
      .status;
}

class LiveClient::Implementation {
public:
  Implementation(std::uint16_t port, int receive_buffer) : socket_(io_)
  {
    asio::ip::tcp::socket& socket = beast::get_lowest_layer(socket_).socket();
    socket.open(asio::ip::tcp::v4());
    if (receive_buffer > 0)
      socket.set_option(asio::socket_base::receive_buffer_size(receive_buffer));
    socket.connect({asio::ip::address_v4::loopback(), port});
    const std::string host = "127.0.0.1:" + std::to_string(port);
    socket_.set_option(
        websocket::stream_base::decorator([host](websocket::request_type& sent) {
          sent.set(beast::http::field::sec_websocket_protocol,
                   "other, pcl_ext.live.v1");
          sent.set(beast::http::field::origin, "http://" + host);
        }));
    socket_.read_message_max(std::size_t{1} << 28);
    websocket::response_type response;
    beast::error_code error = asio::error::timed_out;
    socket_.async_handshake(
        response, host, "/api/live", [&](beast::error_code result) { error = result; });
    wait();
    EXPECT_FALSE(error) << error.message();
    const auto value = response[beast::http::field::sec_websocket_protocol];
    protocol.assign(value.data(), value.size());
  }

  std::optional<LiveMessage>
  next()
  {
    beast::flat_buffer buffer;
    beast::error_code error = asio::error::timed_out;
    socket_.async_read(buffer,
                       [&](beast::error_code result, std::size_t) { error = result; });
    wait();
    if (error)
      return std::nullopt;
    LiveMessage message;
    if (socket_.got_text()) {
      message.text = beast::buffers_to_string(buffer.data());
      return message;
    }
    const auto* const bytes = static_cast<const std::uint8_t*>(buffer.data().data());
    constexpr std::size_t head = 16;
    EXPECT_GE(buffer.size(), head);
    message.stream = static_cast<std::uint32_t>(littleEndian(bytes, 4));
    message.flags = static_cast<std::uint32_t>(littleEndian(bytes + 4, 4));
    message.time = static_cast<std::int64_t>(littleEndian(bytes + 8, 8));
    message.frame.assign(bytes + head, bytes + buffer.size());
    return message;
  }

  bool
  send(const std::string& text)
  {
    beast::error_code error = asio::error::timed_out;
    socket_.text(true);
    socket_.async_write(asio::buffer(text),
                        [&](beast::error_code result, std::size_t) { error = result; });
    wait();
    return !error;
  }

  std::string protocol;

private:
  void
  wait()
  {
    io_.restart();
    io_.run_for(std::chrono::seconds(seconds_to_wait));
    if (io_.stopped())
      return;
    beast::get_lowest_layer(socket_).close();
    io_.run();
  }

  asio::io_context io_;
  websocket::stream<beast::tcp_stream> socket_;
};

LiveClient::LiveClient(std::uint16_t port, int receive_buffer)
: implementation_(new Implementation(port, receive_buffer))
{}

LiveClient::~LiveClient() = default;
LiveClient::LiveClient(LiveClient&&) noexcept = default;

namespace {

bool
isState(const LiveMessage& message)
{
  return message.text.find(R"("type":"state")") != std::string::npos;
}

} // namespace

std::optional<LiveMessage>
LiveClient::next()
{
  std::optional<LiveMessage> message = implementation_->next();
  while (message && isState(*message))
    message = implementation_->next();
  return message;
}

std::string
LiveClient::nextState()
{
  std::optional<LiveMessage> message = implementation_->next();
  while (message && !isState(*message))
    message = implementation_->next();
  return message ? message->text : "";
}

std::optional<LiveMessage>
LiveClient::nextFrame()
{
  std::optional<LiveMessage> message = next();
  while (message && !message->text.empty())
    message = next();
  return message;
}

bool
LiveClient::send(const std::string& text)
{
  return implementation_->send(text);
}

std::string
LiveClient::protocol() const
{
  return implementation_->protocol;
}

ProcessUse
processUse()
{
  const auto entriesOf = [](const char* folder) {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder),
                      std::filesystem::directory_iterator()));
  };
  return {entriesOf("/proc/self/fd"), entriesOf("/proc/self/task")};
}

} // namespace pcl_ext::PCL_EXT_ABI::view::test
