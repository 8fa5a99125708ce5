// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "support/nats_server.h"

#include <atomic>
#include <regex>
#include <string>
#include <thread>

namespace pcl_ext::PCL_EXT_ABI::link::test {

/** \brief A server that brings the first echo of a client and then reads nothing more of
 * its connection, as behind a link that has stalled. It accepts no client after that. */
class StallingNatsServer {
public:
  StallingNatsServer() : listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0))
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

  ~StallingNatsServer()
  {
    ::shutdown(listener_, SHUT_RDWR);
    ::shutdown(client_, SHUT_RDWR);
    thread_.join();
    ::close(listener_);
    ::close(client_);
  }

  StallingNatsServer(const StallingNatsServer&) = delete;
  StallingNatsServer&
  operator=(const StallingNatsServer&) = delete;

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
    send("INFO {\"server_id\":\"stalling\",\"version\":\"2.9.10\",\"headers\":true,"
         "\"max_payload\":1048576}\r\n");
    std::string received;
    while (received.find("PING\r\n") == std::string::npos)
      if (!receive(received))
        return;
    send("PONG\r\n");
    // SUB cell.1.echo 1, and PUB cell.1.echo 1, after which is its content, 1.
    std::smatch echo;
    while (!std::regex_search(received, echo, std::regex("PUB (\\S+) 1\r\n1\r\n")))
      if (!receive(received))
        return;
    send("MSG " + echo[1].str() + " 1 1\r\n1\r\n");
    for (int other = 0; (other = ::accept(listener_, nullptr, nullptr)) >= 0;)
      ::close(other);
  }

  bool
  receive(std::string& received) const
  {
    char buffer[4096];
    const ssize_t size = ::recv(client_, buffer, sizeof(buffer), 0);
    if (size > 0)
      received.append(buffer, static_cast<std::size_t>(size));
    return size > 0;
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
