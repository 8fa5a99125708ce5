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
  StallingNatsServer() : thread_([this] { serve(); }) {}

  ~StallingNatsServer()
  {
    listener_.end();
    ::shutdown(client_, SHUT_RDWR);
    thread_.join();
    ::close(client_);
  }

  StallingNatsServer(const StallingNatsServer&) = delete;
  StallingNatsServer&
  operator=(const StallingNatsServer&) = delete;

  std::string
  url() const
  {
    return listener_.url();
  }

private:
  void
  serve()
  {
    client_ = listener_.accept();
    send("INFO {\"server_id\":\"stalling\",\"version\":\"2.9.10\",\"headers\":true,"
         "\"max_payload\":1048576}\r\n");
    std::string received;
    while (received.find("PING\r\n") == std::string::npos)
      if (!receive(received))
        return;
    send("PONG\r\n");
    // The subject, the number of bytes of the echo, and these.
    const std::regex published("PUB (\\S+) (\\d+)\r\n(\\d+)\r\n");
    std::smatch echo;
    while (!std::regex_search(received, echo, published))
      if (!receive(received))
        return;
    send("MSG " + echo[1].str() + " 1 " + echo[2].str() + "\r\n" + echo[3].str() +
         "\r\n");
    for (int other = 0; (other = listener_.accept()) >= 0;)
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

  const ListeningSocket listener_;
  std::atomic<int> client_{-1};
  std::thread thread_; // last, as it uses the others
};

} // namespace pcl_ext::PCL_EXT_ABI::link::test
