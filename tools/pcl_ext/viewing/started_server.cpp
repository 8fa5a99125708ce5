// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "viewing/started_server.h"

#include "console/throw_unless_ok.h"
#include "viewing/browser.h"

#include <unistd.h>

#include <array>
#include <cstdint>
#include <string>

namespace pcl_ext::tools {

namespace {

std::string
urlForOthers(const std::string& address, std::uint16_t port)
{
  std::array<char, 256> name{};
  const bool is_any = address == "0.0.0.0" || address == "::";
  if (is_any)
    ::gethostname(name.data(), name.size() - 1);
  const bool is_v6 = !is_any && address.find(':') != std::string::npos;
  const std::string host = is_any ? name.data() : is_v6 ? "[" + address + "]" : address;
  return "http://" + host + ":" + std::to_string(port) + "/";
}

} // namespace

void
startServer(view::ViewServer& server,
            const view::ViewServerSettings& settings,
            bool opens_browser,
            Console& console)
{
  throwUnlessOk(server.start());
  if (!server.isLoopback())
    console.error("anyone who can reach this machine can look at the clouds: there is "
                  "no password. Other machines use " +
                  urlForOthers(settings.address, server.port()));
  console.summary(settings.name + ": " + server.url() + " (Ctrl-C ends)");
  if (opens_browser)
    openBrowser(server.url());
}

} // namespace pcl_ext::tools
