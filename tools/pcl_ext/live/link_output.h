// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/link/frame_publisher.h>

#include "console/events.h"
#include "console/interruption.h"
#include "console/throw_unless_ok.h"
#include "live/live_output.h"
#include "options/text_values.h"

#include <cstdint>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::tools {

/** \brief Which frames the server has not, or may not have, for a line; empty if it has
 * all.
 * \param[in] under_way those without an answer that none is expected for any more
 */
inline std::string
lossesOf(const link::PublisherStatistics& sent, std::uint64_t under_way)
{
  const std::uint64_t unknown = sent.frames_unanswered + under_way;
  const std::uint64_t lost = sent.frames_not_sent - sent.frames_unanswered;
  std::string losses;
  if (lost > 0)
    losses += ", " + counted(lost, "frame") + " lost";
  if (unknown > 0)
    losses += "; of " + counted(unknown, "more frame") +
              " it is not known whether the server has " +
              (unknown == 1 ? "it" : "them");
  return losses;
}

/** \brief Publishes frames for other machines. Frames that cannot be sent are lost, which
 * the events tell. */
class LinkOutput : public LiveOutput {
public:
  /** \param[in] settings as completeLinkSettings() leaves them
   * \param[in] prefix put before the names of the streams
   * \param[in] request_i_frame called by other threads
   * \param[in] events must outlive this
   * \throws std::runtime_error if no server takes the connection
   */
  LinkOutput(link::LinkSettings settings,
             std::string prefix,
             const link::FramePublisher::RequestIFrame& request_i_frame,
             Events& events)
  : prefix_(std::move(prefix))
  , events_(events)
  , publisher_(withEvents(settings, events), request_i_frame)
  {
    connect(publisher_);
  }

  std::size_t
  addStream(const std::string& name, const StreamMetadata& metadata) override
  {
    std::size_t stream = 0;
    throwUnlessOk(publisher_.addStream(prefix_ + name, metadata, stream));
    return stream;
  }

  void
  publish(std::size_t stream,
          std::chrono::nanoseconds time,
          std::vector<std::uint8_t> frame) override
  {
    const auto status = publisher_.publish(stream, time, frame.data(), frame.size());
    // A lost connection is an event already.
    if (status.code() == link::LinkCode::FrameTooLarge) {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (told_.insert(stream).second) // once of each stream
        events_.add(status.message());
    }
    else if (!status.ok() && status.code() != link::LinkCode::NotConnected)
      throwUnlessOk(status);
  }

  void
  end() override
  {
    constexpr std::chrono::seconds patience{5};
    // What the server did not permit is known a moment after its answer.
    if (publisher_.flush(patience))
      publisher_.flush(patience);
  }

  link::PublisherStatistics
  statistics() const
  {
    return publisher_.statistics();
  }

  /** \brief Connects a publisher or a subscriber.
   * \throws std::runtime_error if no server takes the connection
   */
  template <typename EndT>
  static void
  connect(EndT& end)
  {
    const link::LinkStatus status = end.connect();
    if (!status.ok() && isInterrupted()) // which is an error of waiting to the library
      throw std::runtime_error("interrupted before the server had answered");
    throwUnlessOk(status);
  }

  /** \brief Settings whose events go to the command. */
  static link::LinkSettings
  withEvents(link::LinkSettings settings, Events& events)
  {
    settings.on_event = [&events](const std::string& event) { events.add(event); };
    return settings;
  }

private:
  const std::string prefix_;
  Events& events_;
  std::mutex mutex_;
  std::set<std::size_t> told_; // streams with a frame that was too large
  link::FramePublisher publisher_;
};

} // namespace pcl_ext::tools
