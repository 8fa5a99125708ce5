// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "support/nats_server.h"

#include <atomic>
#include <string>
#include <thread>

namespace pcl_ext::PCL_EXT_ABI::link::test {

/** \brief A server for one client. It answers the first ping twice, so that a client which
 * counts answers cannot tell any more which ping is answered, and takes messages without
 * delivering them. */
class OddNatsServer {
public:
  OddNatsServer() : listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0))
  {
    sockaddr_in address = loopback(0);
    socklen_t size = sizeof(address);
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    EXPECT_EQ(::bind(listener_, any, size), 0);
    EXPECT_EQ(::listen(listener_, 1), 0);
    EXPECT_EQ(::getsockname(listener_, any, &size), 0);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }

  ~OddNatsServer()
  {
    ::shutdown(listener_, SHUT_RDWR);
    ::shutdown(client_, SHUT_RDWR);
    thread_.join();
    ::close(listener_);
    ::close(client_);
  }

  OddNatsServer(const OddNatsServer&) = delete;
  OddNatsServer&
  operator=(const OddNatsServer&) = delete;

  std::string
  url() const
  {
    return "nats://127.0.0.1:" + std::to_string(port_);
  }

private:
  void
  serve()
  {
    client_ = ::accept(listener_, nullptr, nullptr);
    send("INFO {\"server_id\":\"odd\",\"version\":\"2.9.10\",\"headers\":true,"
         "\"max_payload\":1048576}\r\n");
    const std::string ping = "PING\r\n";
    std::string answer = "PONG\r\nPONG\r\n";
    std::string received;
    char buffer[4096];
    for (ssize_t size = 0; (size = ::recv(client_, buffer, sizeof(buffer), 0)) > 0;) {
      received.append(buffer, static_cast<std::size_t>(size));
      for (std::size_t at = 0; (at = received.find(ping)) != std::string::npos;) {
        received.erase(0, at + ping.size());
        send(answer);
        answer = "PONG\r\n";
      }
      received.erase(0, received.size() - std::min(received.size(), ping.size() - 1));
    }
  }

  void
  send(const std::string& text)
  {
    ::send(client_, text.data(), text.size(), MSG_NOSIGNAL);
  }

  const int listener_;
  std::uint16_t port_ = 0;
  std::atomic<int> client_{-1};
  std::thread thread_;
};

} // namespace pcl_ext::PCL_EXT_ABI::link::test
