// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "support/recorded_streams.h"

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>

namespace pcl_ext::PCL_EXT_ABI::link::test {

using recording::test::TestFolder;

inline sockaddr_in
loopback(std::uint16_t port)
{
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  return address;
}

/** \brief A port of this machine at which nobody answers yet. */
class ListeningSocket {
public:
  ListeningSocket() : descriptor_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0))
  {
    sockaddr_in address = loopback(0);
    socklen_t size = sizeof(address);
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    EXPECT_EQ(::bind(descriptor_, any, size), 0);
    EXPECT_EQ(::listen(descriptor_, 1), 0);
    EXPECT_EQ(::getsockname(descriptor_, any, &size), 0);
    port_ = ntohs(address.sin_port);
  }

  ~ListeningSocket() { ::close(descriptor_); }
  ListeningSocket(const ListeningSocket&) = delete;
  ListeningSocket&
  operator=(const ListeningSocket&) = delete;

  /** \brief Waits for a client.
   * \return its socket, the caller's to close; -1 after end(), or if none comes
   */
  int
  accept() const
  {
    const timeval patience{60, 0};
    ::setsockopt(descriptor_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    return ::accept(descriptor_, nullptr, nullptr);
  }

  void
  end() const
  {
    ::shutdown(descriptor_, SHUT_RDWR);
  }

  std::uint16_t
  port() const
  {
    return port_;
  }

  std::string
  url() const
  {
    return "nats://127.0.0.1:" + std::to_string(port_);
  }

private:
  const int descriptor_;
  std::uint16_t port_ = 0;
};

inline std::uint16_t
freePort()
{
  return ListeningSocket().port();
}

class NatsServer {
public:
  /** \param[in] configuration besides the address, as nats-server reads it; FOLDER stands
   * for a folder of its own
   */
  explicit NatsServer(const std::string& configuration = "")
  : port_(freePort()), configuration_(configuration)
  {
    for (std::size_t at = 0; (at = configuration_.find("FOLDER")) != std::string::npos;)
      configuration_.replace(at, 6, folder_ / "");
    start();
  }

  ~NatsServer() { stop(); }
  NatsServer(const NatsServer&) = delete;
  NatsServer&
  operator=(const NatsServer&) = delete;

  void
  start()
  {
    writeConfiguration();
    const std::string file = folder_ / "server.conf";
    pid_ = ::fork();
    if (pid_ == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      // Debian has it where only administrators look.
      const char* const path = std::getenv("PATH");
      ::setenv("PATH",
               (std::string(path != nullptr ? path : "") +
                ":/usr/sbin:" PCL_EXT_NATS_SERVER_FOLDER)
                   .c_str(),
               1);
      ::execlp("nats-server",
               "nats-server",
               "-c",
               file.c_str(),
               static_cast<char*>(nullptr));
      ::_exit(127);
    }
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!answers()) {
      const bool has_ended = ::waitpid(pid_, nullptr, WNOHANG) != 0;
      if (has_ended || std::chrono::steady_clock::now() > end) {
        if (has_ended)
          pid_ = -1;
        stop();
        // Ends the test: without a server the rest of it waits for minutes.
        throw std::runtime_error(
            "the program nats-server does not start; its package is nats-server");
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }

  void
  stop()
  {
    if (pid_ <= 0)
      return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }

  /** \brief Makes it read another configuration, which it does soon. */
  void
  reload(const std::string& configuration)
  {
    configuration_ = configuration;
    writeConfiguration();
    ::kill(pid_, SIGHUP);
  }

  /** \brief Makes it hang, so that it takes and answers nothing, as behind a pulled
   * cable. */
  void
  hang()
  {
    ::kill(pid_, SIGSTOP);
    ::waitpid(pid_, nullptr, WUNTRACED); // until all of its threads have stopped
  }

  void
  goOn()
  {
    ::kill(pid_, SIGCONT);
  }

  std::string
  url(const std::string& scheme = "nats") const
  {
    return scheme + "://127.0.0.1:" + std::to_string(port_);
  }

private:
  void
  writeConfiguration() const
  {
    std::ofstream(folder_ / "server.conf")
        << "listen: \"127.0.0.1:" << port_ << "\"\nlog_file: \""
        << folder_ / "server.log"
        << "\"\n"
        << configuration_ << '\n';
  }

  bool
  answers() const
  {
    const int descriptor = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address = loopback(port_);
    const bool is_connected =
        ::connect(descriptor, reinterpret_cast<sockaddr*>(&address), sizeof(address)) ==
        0;
    ::close(descriptor);
    return is_connected;
  }

  /** \brief A folder that no other server of the test has. */
  class Folder {
  public:
    Folder()
    {
      path_ = ::testing::TempDir() + "pcl_ext_nats_XXXXXX";
      EXPECT_NE(::mkdtemp(path_.data()), nullptr);
    }

    ~Folder()
    {
      std::error_code ignored;
      std::filesystem::remove_all(path_, ignored);
    }

    Folder(const Folder&) = delete;
    Folder&
    operator=(const Folder&) = delete;

    std::string
    operator/(const std::string& name) const
    {
      return path_ + "/" + name;
    }

  private:
    std::string path_;
  };

  Folder folder_;
  const std::uint16_t port_;
  std::string configuration_;
  pid_t pid_ = -1;
};

} // namespace pcl_ext::PCL_EXT_ABI::link::test
