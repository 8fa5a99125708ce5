// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/nodes/impl/cloud_sender.h>

#include "support/node_tests.h"

namespace {

namespace cloud_sender_rate {

using namespace pcl_ext::nodes::test;

class Stream {
public:
  Stream() : sender_(settingsWith(clock_)) {}

  /** \brief Sends a cloud, a second after the last one.
   * \return 'I' or 'P'; '-': none
   */
  char
  send()
  {
    clock_.set(now_ += 1s);
    Bytes bytes;
    const SensorNodeStatus status = sender_.encode(cloud_, poseOf(0), 1, bytes);
    message_ = status.message();
    if (!status.hasFrame())
      return '-';
    FrameDecoder decoder;
    pcl_ext::io::VoxelFrame frame;
    return decoder.decode(bytes.data(), bytes.size(), frame).ok() ? 'I' : 'P';
  }

  char
  sendWith(const ParameterValues& values)
  {
    EXPECT_EQ(sender_.setParameters(values), "");
    return send();
  }

  CloudSender&
  sender()
  {
    return sender_;
  }

  const std::string&
  message() const
  {
    return message_;
  }

private:
  static SensorNodeSettings
  settingsWith(const FakeClock& clock)
  {
    SensorNodeSettings settings;
    settings.clock = clock.clock();
    return settings;
  }

  FakeClock clock_;
  Time now_ = 1000s;
  CloudSender sender_;
  pcl::PCLPointCloud2 cloud_ = messageOf(cloudSeenFrom(poseOf(0), 1, 300));
  std::string message_;
};

TEST(CloudSenderRate, FromOneLimitToAnotherTheStreamGoesOn)
{
  Stream stream;
  EXPECT_EQ(stream.send(), 'I');
  EXPECT_EQ(stream.send(), 'P');
  EXPECT_EQ(stream.sendWith({{"max_rate", 1e7}}), 'I');
  EXPECT_EQ(stream.send(), 'P');
  ASSERT_EQ(stream.sender().settings().law, IntensityLaw::Native); // of its clouds
  EXPECT_EQ(stream.sendWith({{"max_rate", 2e7}}), 'P');
  EXPECT_EQ(stream.message(), "");
  EXPECT_EQ(stream.sender().settings().law, IntensityLaw::Native);
  EXPECT_EQ(stream.sender().health().node.rate_control.max_rate, 2e7);
  EXPECT_EQ(stream.sender().settings().compression.max_rate, 2e7);
  EXPECT_EQ(stream.sender().health().node.frames, 3u);
  EXPECT_EQ(stream.sendWith({{"max_rate", 3e7}, {"rate_buffer", 0.5}}), 'I');
  EXPECT_EQ(stream.sendWith({{"max_rate", 0.0}}), 'I');
  EXPECT_FALSE(stream.sender().health().node.rate_control.is_on);
}

TEST(CloudSenderRate, CloudsWithoutRoomAreLeftOutAndReported)
{
  Stream stream;
  const SenderHealth before = stream.sender().health();
  // Of one point each there would be room; of none for these.
  EXPECT_EQ(stream.sendWith({{"max_rate", 1000.0}, {"rate_doublings", 0}}), '-');
  EXPECT_EQ(
      stream.message().rfind("the cloud was left out, as max_rate of 1 kbit/s has "
                             "room for 31 bytes now",
                             0),
      0u)
      << stream.message();
  const SenderHealth health = stream.sender().health();
  EXPECT_EQ(health.node.rate_control.clouds_left_out, 1u);
  EXPECT_EQ(health.node.clouds_refused, 0u);
  EXPECT_EQ(describeHealth(health, before, *health.last_arrival).message(),
            "Clouds are left out, as max_rate has no room");
}

} // namespace cloud_sender_rate

} // namespace
