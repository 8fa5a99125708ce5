// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/clients.h"
#include "view/running_server.h"

#include <gtest/gtest.h>

#include <atomic>

namespace pcl_ext::PCL_EXT_ABI::view::test {

namespace {

constexpr char text_format[] = "text/plain; version=0.0.4; charset=utf-8";

/** \brief What the text tells of a metric without labels; empty if it tells nothing. */
std::string
valueOf(const std::string& text, const std::string& name)
{
  const std::size_t at = text.find('\n' + name + ' ');
  if (at == std::string::npos)
    return {};
  const std::size_t begin = at + name.size() + 2;
  return text.substr(begin, text.find('\n', begin) - begin);
}

} // namespace

TEST(ServerMetrics, AreOfTheServerAlone)
{
  RunningServer live;
  LiveClient client(live.port());
  ASSERT_TRUE(live.waitForViewers(1));
  LiveSource source(10);
  live.publish(0, 0, source.next());
  ASSERT_TRUE(client.nextFrame());
  const HttpAnswer answer = request(live.port(), "/metrics?x=1");
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.headers.at("content-type"), text_format);
  EXPECT_EQ(answer.headers.at("cache-control"), "no-store");
  EXPECT_EQ(answer.headers.count("etag"), 0u);
  EXPECT_EQ(answer.body.rfind("# HELP pcl_ext_view_connections ", 0), 0u);
  EXPECT_EQ(valueOf(answer.body, "pcl_ext_view_connections"), "2");
  EXPECT_EQ(valueOf(answer.body, "pcl_ext_view_viewers"), "1");
  EXPECT_EQ(valueOf(answer.body, "pcl_ext_view_frames_total"), "1");
  EXPECT_EQ(valueOf(answer.body, "pcl_ext_view_frames_sent_total"), "1");
  EXPECT_EQ(valueOf(answer.body, "pcl_ext_view_frames_skipped_total"), "0");
}

TEST(ServerMetrics, FollowThoseOfTheProgram)
{
  std::atomic<int> calls{0};
  ViewServerSettings settings;
  settings.metrics = [&calls] {
    return "# TYPE x gauge\nx " + std::to_string(++calls) + "\n";
  };
  ViewServer server(settings);
  ASSERT_TRUE(server.start().ok());
  for (const char* first :
       {"# TYPE x gauge\nx 1\n# HELP", "# TYPE x gauge\nx 2\n# HELP"})
    EXPECT_EQ(request(server.port(), "/metrics").body.rfind(first, 0), 0u);
  const HttpAnswer head = request(server.port(), "/metrics", "", "HEAD");
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.headers.at("content-type"), text_format);
  EXPECT_EQ(request(server.port(), "/metrics", "Host: example.org\r\n").status, 421);
  EXPECT_EQ(request(server.port(), "/metrics", "", "POST").status, 405);
  EXPECT_EQ(upgradeStatus(server.port(), "", "/metrics"), 404);
  EXPECT_EQ(request(server.port(), "/metrics/").status, 404);
  EXPECT_EQ(calls, 3);
}

} // namespace pcl_ext::PCL_EXT_ABI::view::test
