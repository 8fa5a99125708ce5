// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/nodes/impl/health_metrics.h>

#include "bytes/metrics_text.h"

#include <gtest/gtest.h>

#include <limits>

namespace {

using namespace pcl_ext::nodes;
using namespace std::chrono_literals;
using pcl_ext::MetricsText;

std::string
samplesOf(const std::string& text, const std::string& family)
{
  std::string samples;
  for (std::size_t at = text.find('\n' + family); at != std::string::npos;
       at = text.find('\n' + family, at + 1)) {
    const std::size_t begin = at + 1 + family.size();
    samples += text.substr(begin, text.find('\n', begin) + 1 - begin);
  }
  return samples;
}

TEST(HealthMetrics, OfStreams)
{
  StreamHealth health;
  health.name = "/a";
  EXPECT_EQ(samplesOf(streamMetrics({health}, 100s), "pcl_ext_stream_age_seconds"), "");
  health.frames_decoded = 12;
  health.frames_lost = 3;
  health.bytes = 1'234'567'890'123;
  health.in_sync = true;
  health.last_decoded = 98'500ms;
  StreamHealth other;
  other.name = "/b";
  const std::string text = streamMetrics({health, other}, 100s, {{"site", "x"}});
  EXPECT_EQ(text.substr(0, text.find("# HELP", 1)),
            "# HELP pcl_ext_stream_frames_received_total Frames that arrived.\n"
            "# TYPE pcl_ext_stream_frames_received_total counter\n"
            "pcl_ext_stream_frames_received_total{site=\"x\",stream=\"/a\"} 0\n"
            "pcl_ext_stream_frames_received_total{site=\"x\",stream=\"/b\"} 0\n");
  const auto samples = [&text](const std::string& family) {
    return samplesOf(text, "pcl_ext_stream_" + family);
  };
  const std::string a = "{site=\"x\",stream=\"/a\"} ";
  const std::string b = "{site=\"x\",stream=\"/b\"} ";
  EXPECT_EQ(samples("frames_decoded_total"), a + "12\n" + b + "0\n");
  EXPECT_EQ(samples("frames_lost_total"), a + "3\n" + b + "0\n");
  EXPECT_EQ(samples("received_bytes_total"), a + "1234567890123\n" + b + "0\n");
  EXPECT_EQ(samples("in_sync"), a + "1\n" + b + "0\n");
  EXPECT_EQ(samples("age_seconds"), a + "1.5\n");
  EXPECT_EQ(samples("latency_seconds"), "");
}

TEST(HealthMetrics, BucketsAreCumulative)
{
  StreamHealth health;
  health.name = "/a";
  for (const double seconds : {0.0, 0.0001, 0.0002, 0.5, 0.75, 1.5})
    health.decode_times.add(seconds);
  EXPECT_EQ(health.decode_times.count(), 6u);
  EXPECT_EQ(
      samplesOf(streamMetrics({health}, 0s), "pcl_ext_stream_decode_seconds_"),
      "bucket{stream=\"/a\",le=\"0.0001\"} 2\nbucket{stream=\"/a\",le=\"0.00025\"} 3\n"
      "bucket{stream=\"/a\",le=\"0.0005\"} 3\nbucket{stream=\"/a\",le=\"0.001\"} 3\n"
      "bucket{stream=\"/a\",le=\"0.0025\"} 3\nbucket{stream=\"/a\",le=\"0.005\"} 3\n"
      "bucket{stream=\"/a\",le=\"0.01\"} 3\nbucket{stream=\"/a\",le=\"0.025\"} 3\n"
      "bucket{stream=\"/a\",le=\"0.05\"} 3\nbucket{stream=\"/a\",le=\"0.1\"} 3\n"
      "bucket{stream=\"/a\",le=\"0.25\"} 3\nbucket{stream=\"/a\",le=\"0.5\"} 4\n"
      "bucket{stream=\"/a\",le=\"1\"} 5\nbucket{stream=\"/a\",le=\"+Inf\"} 6\n"
      "sum{stream=\"/a\"} 2.7503\ncount{stream=\"/a\"} 6\n");
}

TEST(HealthMetrics, OfSenders)
{
  SenderHealth health;
  EXPECT_EQ(
      samplesOf(senderMetrics({{"/a", health}}, 100s), "pcl_ext_sender_age_seconds"),
      "");
  health.last_arrival = 99s;
  health.clouds_of_other_frame = 2;
  health.node.clouds_without_transform = 3;
  health.node.frame_bytes = 7;
  health.node.rates.mean_latency_seconds = 0.25;
  health.node.encode_times.add(0.25);
  const std::string text = senderMetrics({{"/a", health}}, 100s);
  const auto samples = [&text](const std::string& family) {
    return samplesOf(text, "pcl_ext_sender_" + family + "{stream=\"/a\"} ");
  };
  EXPECT_EQ(samples("age_seconds"), "1\n");
  EXPECT_EQ(samples("clouds_without_transform_total"), "5\n");
  EXPECT_EQ(samples("frame_bytes_total"), "7\n");
  EXPECT_EQ(samples("latency_seconds"), "0.25\n");
  EXPECT_EQ(samples("encode_seconds_sum"), "0.25\n");
  EXPECT_EQ(samples("encode_seconds_count"), "1\n");
  // Nothing has come for longer than the latency is a mean of.
  EXPECT_EQ(samplesOf(senderMetrics({{"/a", health}}, 102s), "pcl_ext_sender_latency"),
            "");
}

TEST(MetricsText, LabelsHaveAnyBytes)
{
  const auto value = [](const std::string& text) {
    return MetricsText::labelOf("l", text);
  };
  EXPECT_EQ(value("a\"b\\c\nd}"), "l=\"a\\\"b\\\\c\\nd}\"");
  EXPECT_EQ(value("\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80"),
            "l=\"\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80\"");
  EXPECT_EQ(value(std::string("a\0b", 3)), "l=\"a\\\\x00b\"");
  // A longer form, a surrogate, above U+10FFFF, a character that was cut off.
  EXPECT_EQ(value("\xc0\x80"), "l=\"\\\\xc0\\\\x80\"");
  EXPECT_EQ(value("\xed\xa0\x80"), "l=\"\\\\xed\\\\xa0\\\\x80\"");
  EXPECT_EQ(value("\xf4\x90\x80\x80"), "l=\"\\\\xf4\\\\x90\\\\x80\\\\x80\"");
  EXPECT_EQ(value("a\xe2\x82"), "l=\"a\\\\xe2\\\\x82\"");
  // The text that stands for a byte, and that which stands for this text.
  EXPECT_EQ(value("\\xff"), "l=\"\\\\x5cxff\"");
  EXPECT_EQ(value("\\x5cxff"), "l=\"\\\\x5cx5cxff\"");
}

TEST(MetricsText, NumbersAreFiniteAndPlain)
{
  MetricsText text;
  text.beginFamily("f", "gauge", "Help.");
  for (const double value : {std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity(),
                             0.0,
                             -2.5,
                             0.1,
                             123456789012.0,
                             9007199254740992.0,
                             1e-9})
    text.add(value);
  EXPECT_EQ(text.text(),
            "# HELP f Help.\n# TYPE f gauge\nf 0\nf -2.5\nf 0.1\nf 123456789012\n"
            "f 9.007199254740992e+15\nf 1e-09\n");
}

} // namespace
