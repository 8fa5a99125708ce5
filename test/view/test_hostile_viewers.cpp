// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/clients.h"
#include "view/running_server.h"

#include <gtest/gtest.h>

#include <sys/resource.h>

#include <random>

namespace pcl_ext::PCL_EXT_ABI::view::test {

namespace {

void
expectService(RunningServer& live)
{
  EXPECT_EQ(request(live.port(), "/").body, test_page);
  LiveClient client(live.port());
  LiveSource source(10);
  const Bytes frame = source.next();
  live.publish(0, 0, frame);
  EXPECT_EQ(client.nextFrame()->frame, frame);
}

std::string
garbage(std::mt19937& random)
{
  static const std::vector<std::string> words = {"GET ",
                                                 "HEAD ",
                                                 "POST ",
                                                 "/",
                                                 "/api/files/0",
                                                 "/api/live",
                                                 "/metrics",
                                                 " HTTP/1.1\r\n",
                                                 "Host: ",
                                                 "localhost",
                                                 "\r\n",
                                                 "\r\n\r\n",
                                                 "Range: bytes=",
                                                 "0-",
                                                 ",",
                                                 "Upgrade: websocket\r\n",
                                                 "Origin: ",
                                                 "Content-Length:",
                                                 "chunked",
                                                 "%2e%2e/",
                                                 "../",
                                                 ":",
                                                 " ",
                                                 "Connection: upgrade\r\n",
                                                 "\0"};
  std::string text;
  const std::size_t parts = random() % 30;
  for (std::size_t i = 0; i < parts; ++i)
    if (random() % 4 == 0)
      for (std::size_t j = random() % 20; j > 0; --j)
        text += static_cast<char>(random());
    else
      text += words[random() % words.size()];
  return text;
}

} // namespace

TEST(HostileViewers, RandomRequestsHarmNobody)
{
  RunningServer live;
  std::mt19937 random(1);
  for (int i = 0; i < 5000; ++i) {
    RawConnection connection(live.port());
    connection.send(garbage(random));
  }
  expectService(live);
  EXPECT_TRUE(live.waitForConnections(0));
}

TEST(HostileViewers, RandomMessagesHarmNobody)
{
  RunningServer live;
  std::mt19937 random(2);
  std::optional<LiveClient> client(live.port());
  static const std::vector<std::string> words = {"{",
                                                 "}",
                                                 "\"type\"",
                                                 ":",
                                                 "\"i-frame\"",
                                                 ",",
                                                 "\"stream\"",
                                                 "0",
                                                 "-1",
                                                 "1e9",
                                                 "[",
                                                 "]"};
  for (int i = 0; i < 5000; ++i) {
    std::string text;
    for (std::size_t j = random() % 12; j > 0; --j)
      text += words[random() % words.size()];
    if (random() % 8 == 0)
      text.append(random() % 4 == 0 ? 2000 : 5, static_cast<char>(random()));
    // The server closes connections whose texts are no UTF-8, or too long.
    if (!client->send(text))
      client.emplace(live.port());
  }
  client.reset();
  expectService(live);
}

TEST(HostileViewers, ALongMessageClosesTheConnection)
{
  RunningServer live;
  LiveClient client(live.port());
  client.next(); // the streams
  EXPECT_TRUE(client.send(std::string(1024, ' ')));
  EXPECT_TRUE(client.send(std::string(1025, ' ')));
  EXPECT_FALSE(client.next().has_value());
  EXPECT_TRUE(live.waitForViewers(0));
}

TEST(HostileViewers, FragmentsDoNotMakeALongMessage)
{
  ViewServerLimits limits;
  limits.idle_timeout = std::chrono::milliseconds(500); // it does not answer the close
  RunningServer live(limits);
  RawConnection connection(live.port());
  connection.send("GET /api/live HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\n"
                  "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                  "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n");
  EXPECT_TRUE(hasPart(connection.receiveUntil("\r\n\r\n"), " 101 "));
  // A text that never ends: 100 bytes a fragment, with a mask of zeros.
  const std::string key(4, '\0');
  const std::string rest = "\xe4" + key + std::string(100, 'x');
  std::string fragments = "\x01" + rest;
  for (int i = 0; i < 10; ++i)
    fragments += std::string(1, '\0') + rest;
  connection.send(fragments);
  EXPECT_TRUE(connection.receiveAll().has_value());
  EXPECT_TRUE(live.waitForConnections(0));
}

TEST(HostileViewers, SlowRequestsAreClosed)
{
  ViewServerLimits limits;
  limits.header_timeout = std::chrono::milliseconds(300);
  limits.idle_timeout = std::chrono::milliseconds(300);
  RunningServer live(limits);
  RawConnection silent(live.port());
  RawConnection half(live.port());
  half.send("GET / HTTP/1.1\r\nHo");
  RawConnection idle(live.port());
  idle.send("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(idle.receiveUntil("</body>").substr(0, 12), "HTTP/1.1 200");
  // Byte by byte; each comes in time, the head does not.
  RawConnection slow(live.port());
  bool is_open = true;
  for (int i = 0; i < 10'000 && is_open; ++i) {
    is_open = slow.send("x");
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_FALSE(is_open);
  EXPECT_EQ(silent.receiveAll(), "");
  EXPECT_EQ(half.receiveAll(), "");
  EXPECT_EQ(idle.receiveAll(), "");
  EXPECT_TRUE(live.waitForConnections(0));
}

TEST(HostileViewers, AViewerThatAnswersNoPingIsClosedAndOthersStay)
{
  ViewServerLimits limits;
  limits.idle_timeout = std::chrono::milliseconds(200);
  RunningServer live(limits);
  LiveClient silent(live.port()); // reads, and thus answers, only in next()
  LiveClient client(live.port());
  ASSERT_TRUE(live.waitForViewers(2));
  std::thread late([&] {
    EXPECT_TRUE(live.waitForViewers(1));
    std::this_thread::sleep_for(3 * limits.idle_timeout);
    LiveSource source(10);
    live.publish(0, 0, source.next());
  });
  EXPECT_TRUE(client.nextFrame().has_value());
  late.join();
  EXPECT_FALSE(silent.nextFrame().has_value());
}

TEST(HostileViewers, AReaderThatStopsIsClosed)
{
  ViewServerLimits limits;
  limits.idle_timeout = std::chrono::milliseconds(300);
  ViewServerSettings settings;
  settings.limits = limits;
  settings.page = std::string(std::size_t{1} << 25, 'x'); // more than buffers hold
  ViewServer server(settings);
  ASSERT_TRUE(server.start().ok());
  RawConnection connection(server.port());
  connection.send("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(connection.receive(12), "HTTP/1.1 200");
  EXPECT_TRUE(waitFor([&] { return server.statistics().connections == 0; }));
}

TEST(HostileViewers, TooManyConnectionsAreRefused)
{
  ViewServerLimits limits;
  limits.max_connections = 5;
  RunningServer live(limits);
  std::vector<std::unique_ptr<RawConnection>> connections;
  for (int i = 0; i < 5; ++i)
    connections.push_back(std::make_unique<RawConnection>(live.port()));
  ASSERT_TRUE(live.waitForConnections(5));
  RawConnection refused(live.port());
  EXPECT_EQ(refused.receiveAll().value_or("").substr(0, 12), "HTTP/1.1 503");
  EXPECT_EQ(live.server->statistics().refused, 1u);
  connections.clear();
  ASSERT_TRUE(live.waitForConnections(0));
  expectService(live);
}

TEST(HostileViewers, DescriptorsThatRunOutAreAwaited)
{
  RunningServer live;
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  {
    RawConnection waiting(live.port()); // is accepted before the limit
    ASSERT_TRUE(live.waitForConnections(1));
    RawConnection client(live.port());
    ASSERT_TRUE(live.waitForConnections(2));
  }
  ASSERT_TRUE(live.waitForConnections(0));
  const std::size_t open = processUse().descriptors;
  // One for the client, none for the server.
  const rlimit few{open, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
  std::optional<RawConnection> client;
  client.emplace(live.port());
  client->send("GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_TRUE(hasPart(client->receiveAll().value_or(""), test_page));
}

TEST(HostileViewers, TheServerCanEndWhileViewersAreConnected)
{
  const ProcessUse before = processUse();
  for (int i = 0; i < 5; ++i) {
    RunningServer live;
    std::vector<LiveClient> clients;
    for (int j = 0; j < 5; ++j)
      clients.emplace_back(live.port());
    RawConnection half(live.port());
    half.send("GET / HT");
    ASSERT_TRUE(live.waitForViewers(5));
    LiveSource source(10, 2000);
    for (std::size_t j = 0; j < 20; ++j)
      live.publish(0, j, source.next());
    live.server.reset();
    for (LiveClient& client : clients)
      while (client.next()) {
      }
    EXPECT_EQ(half.receiveAll(), "");
  }
  const ProcessUse after = processUse();
  EXPECT_EQ(after.descriptors, before.descriptors);
  EXPECT_EQ(after.threads, before.threads);
}

TEST(ViewServer, APortThatIsTakenIsAnError)
{
  RunningServer first;
  ViewServerSettings settings;
  settings.port = first.port();
  ViewServer second(settings);
  const ViewServerStatus status = second.start();
  EXPECT_EQ(status.code(), ViewServerCode::CannotListen);
  EXPECT_TRUE(hasPart(status.message(), "port " + std::to_string(first.port())));
  EXPECT_TRUE(hasPart(status.message(), "is taken"));
}

TEST(ViewServer, AddressesAreNumbersOfThisMachine)
{
  const auto start = [](const std::string& address, bool is_loopback) {
    ViewServerSettings settings;
    settings.address = address;
    ViewServer server(settings);
    const ViewServerStatus status = server.start();
    EXPECT_EQ(server.isLoopback(), is_loopback) << address;
    if (status.ok()) {
      EXPECT_EQ(request(server.port(), "/", "Host: example.org\r\n").status,
                is_loopback ? 421 : 200);
    }
    return status.code();
  };
  EXPECT_EQ(start("127.0.0.1", true), ViewServerCode::Ok);
  EXPECT_EQ(start("0.0.0.0", false), ViewServerCode::Ok);
  EXPECT_EQ(start("localhost", true), ViewServerCode::InvalidArgument);
  EXPECT_EQ(start("1.2.3", true), ViewServerCode::InvalidArgument);
  EXPECT_EQ(start("203.0.113.7", true), ViewServerCode::CannotListen);
}

} // namespace pcl_ext::PCL_EXT_ABI::view::test
