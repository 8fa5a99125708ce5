// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "link/connection.h"
#include "link/subjects.h"

#include <atomic>
#include <deque>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::link {

namespace {

/** \brief Listening ends then, as sites may have gigabits a second. */
constexpr std::size_t most_messages = 4000;

LinkStatus
listen(LinkSettings link,
       std::chrono::milliseconds duration,
       std::vector<SiteStream>& streams)
{
  streams.clear();
  // That other sites are not permitted is no event of the caller's site.
  link.on_event = nullptr;
  Connection connection(link, nullptr);
  if (LinkStatus status = connection.open(); !status.ok())
    return status;
  std::atomic<std::size_t> messages{0};
  std::mutex mutex; // guards what follows
  std::set<SiteStream> all;
  const auto take = [&](natsMsg* message) {
    ++messages;
    guarded([&] {
      if (auto stream = siteStreamOf(natsMsg_GetSubject(message))) {
        const std::lock_guard<std::mutex> lock(mutex);
        all.insert(std::move(*stream));
      }
      return LinkStatus();
    });
  };
  {
    std::deque<Subscription> subscriptions;
    for (const std::string& sites : {std::string("*"), link.site})
      for (const char* const part : {"", ".*"}) {
        const natsStatus status = subscriptions.emplace_back().open(
            connection, sites + ".*.frames" + part, take);
        if (status != NATS_OK)
          return connection.statusOf(status);
      }
    const auto end = std::chrono::steady_clock::now() + duration;
    while (std::chrono::steady_clock::now() < end && messages < most_messages)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  streams.assign(all.begin(), all.end());
  return {};
}

} // namespace

LinkStatus
liveStreams(const LinkSettings& link,
            std::chrono::milliseconds duration,
            std::vector<SiteStream>& streams) noexcept
{
  return guarded([&] { return listen(link, duration, streams); });
}

} // namespace pcl_ext::PCL_EXT_ABI::link
