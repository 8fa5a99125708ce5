// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/view/view_server.h>

#include "view/live_source.h"

#include <atomic>
#include <memory>
#include <string>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::view::test {

constexpr char test_page[] = "<!doctype html><title>test</title><body>page</body>";

/** \brief A server and how often an I-frame was requested of it. */
class RunningServer {
public:
  explicit RunningServer(const ViewServerLimits& limits = ViewServerLimits(),
                         std::size_t streams = 1)
  {
    ViewServerSettings settings;
    settings.page = test_page;
    settings.name = "test";
    settings.limits = limits;
    settings.request_i_frame = [this](std::size_t) { ++requests; };
    server = std::make_unique<ViewServer>(settings);
    const ViewServerStatus status = server->start();
    EXPECT_TRUE(status.ok()) << status;
    for (std::size_t i = 0; i < streams; ++i) {
      std::size_t number = ~std::size_t{0};
      EXPECT_TRUE(server->addStream("/sensor_" + std::to_string(i), {}, number).ok());
      EXPECT_EQ(number, i);
    }
  }

  void
  publish(std::size_t stream, std::size_t number, Bytes frame)
  {
    const ViewServerStatus status =
        server->publish(stream, timeOfFrame(number), std::move(frame));
    EXPECT_TRUE(status.ok()) << status;
  }

  std::uint16_t
  port() const
  {
    return server->port();
  }

  bool
  waitForViewers(std::size_t count) const
  {
    return waitFor([&] { return server->statistics().viewers == count; });
  }

  bool
  waitForConnections(std::size_t count) const
  {
    return waitFor([&] { return server->statistics().connections == count; });
  }

  std::atomic<std::size_t> requests{0};
  std::unique_ptr<ViewServer> server;
};

} // namespace pcl_ext::PCL_EXT_ABI::view::test
