// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/link/frame_publisher.h>
#include <pcl_ext/link/frame_subscriber.h>

#include "support/nats_server.h"
#include "support/status_codes.h"
#include "view/live_source.h"

#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::link::test {

using pcl_ext::test::expectCode;
using pcl_ext::test::hasPart;
using view::test::Bytes;
using view::test::LiveSource;
using view::test::waitFor;

constexpr char site[] = "cell";

inline LinkSettings
settingsOf(const NatsServer& server)
{
  LinkSettings settings;
  settings.servers = server.url();
  settings.site = site;
  return settings;
}

class Sensor {
public:
  explicit Sensor(const LinkSettings& settings,
                  const std::string& name = "/sensor_1",
                  unsigned int i_frame_rate = 1000,
                  std::uint64_t seed = 1)
  : source_(i_frame_rate, 2, seed)
  , publisher_(settings, [this](std::size_t) { wants_i_frame_ = true; })
  {
    expectCode(publisher_.connect(), LinkCode::Ok);
    expectCode(publisher_.addStream(name, {{"sensor_pose", "1,2,3,0,0,0,1"}}, stream_),
               LinkCode::Ok);
  }

  /** \brief Encodes a frame, publishes it and waits until the server has it.
   * \param[in] flushes whether it waits
   */
  LinkStatus
  publish(bool flushes = true)
  {
    if (wants_i_frame_.exchange(false))
      source_.requestIFrame();
    frames_.push_back(source_.next());
    const LinkStatus status = publisher_.publish(stream_,
                                                 timeOf(frames_.size() - 1),
                                                 frames_.back().data(),
                                                 frames_.back().size());
    if (flushes)
      publisher_.flush(std::chrono::seconds(10));
    return status;
  }

  static Time
  timeOf(std::size_t number)
  {
    return std::chrono::milliseconds(1000 + 10 * number);
  }

  const std::vector<Bytes>&
  frames() const
  {
    return frames_;
  }

  bool
  wantsIFrame() const
  {
    return wants_i_frame_;
  }

  FramePublisher&
  publisher()
  {
    return publisher_;
  }

private:
  LiveSource source_;
  std::atomic<bool> wants_i_frame_{false};
  std::vector<Bytes> frames_;
  FramePublisher publisher_;
  std::size_t stream_ = 0;
};

/** \brief Takes all frames that come until none came for a while, and expects that each
 * stream can be decoded without a fault. */
class Receiver {
public:
  explicit Receiver(const SubscriberSettings& settings) : subscriber(settings)
  {
    expectCode(subscriber.connect(), LinkCode::Ok);
  }

  explicit Receiver(const LinkSettings& settings)
  : Receiver([&] {
    SubscriberSettings all;
    all.link = settings;
    return all;
  }())
  {}

  bool
  take(std::chrono::milliseconds timeout = std::chrono::seconds(20))
  {
    LinkFrame frame;
    if (!subscriber.next(frame, timeout).ok())
      return false;
    // An I-frame needs nothing of what came before.
    if (frame.is_i_frame)
      decoders_[frame.stream] = io::FrameDecoder();
    io::VoxelFrame voxels;
    const auto decoded =
        decoders_[frame.stream].decode(frame.bytes.data(), frame.bytes.size(), voxels);
    EXPECT_TRUE(decoded.ok()) << frame.stream << ": " << decoded.message();
    frames.push_back(std::move(frame));
    return true;
  }

  LinkStreamStatistics
  statisticsOf(const std::string& stream) const
  {
    for (const LinkStreamStatistics& one : subscriber.statistics().streams)
      if (one.name == stream)
        return one;
    return {};
  }

  /** \brief Takes all frames that the server had before. */
  void
  takeAll(const LinkSettings& settings)
  {
    // Messages of a subscription arrive in their order.
    Sensor last(settings, "/last");
    last.publish();
    EXPECT_TRUE(waitFor([&] { return statisticsOf("/last").frames == 1; }));
    while (take(std::chrono::milliseconds(0)))
      ;
    EXPECT_EQ(frames.back().stream, "/last");
    frames.pop_back();
  }

  /** \brief Lets a sensor publish until its last frame has arrived: the server may know
   * the subscription late, and an I-frame comes only when it was asked for. */
  bool
  takesLatest(Sensor& sensor)
  {
    return waitFor([&] {
      sensor.publish();
      while (take(std::chrono::milliseconds(50)))
        ;
      return !frames.empty() && frames.back().bytes == sensor.frames().back();
    });
  }

  FrameSubscriber subscriber;
  std::vector<LinkFrame> frames;

private:
  std::map<std::string, io::FrameDecoder> decoders_;
};

} // namespace pcl_ext::PCL_EXT_ABI::link::test
