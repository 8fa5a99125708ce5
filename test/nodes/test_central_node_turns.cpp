// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/node_tests.h"

#include <thread>

namespace {

using namespace pcl_ext::nodes::test;

CentralNodeSettings
settingsOfOneThread()
{
  CentralNodeSettings settings = centralSettings();
  settings.threads = 1;
  return settings;
}

TEST(CentralNodeTurns, WhatWaitsCanBeRefused)
{
  const CodedStream stream = streamOf(6);
  Gate gate;
  CentralNode node(settingsOfOneThread(), [&](const ReceivedFrame&) { gate.pass(); });
  node.addStream("a");
  node.addStream("b");
  for (std::size_t i = 0; i < 5; ++i)
    send(node, "a", stream.frames[i]);
  send(node, "b", stream.frames[0]);
  gate.waitForArrivals(1);
  EXPECT_FALSE(node.waitUntilDecoded(Time(0)));
  std::thread refusing([&] { node.refuseWaiting(); });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  gate.open();
  refusing.join();
  EXPECT_TRUE(node.waitUntilDecoded(Time(0)));
  std::vector<StreamHealth> health = node.health();
  EXPECT_EQ(health[0].frames_decoded + health[0].frames_refused, 5u);
  EXPECT_GE(health[0].frames_decoded, 1u);
  EXPECT_EQ(health[1].frames_decoded + health[1].frames_refused, 1u);
  // What comes then is decoded.
  send(node, "b", stream.frames[0]);
  node.waitUntilDecoded();
  EXPECT_GE(node.health()[1].frames_decoded, 1u);
}

TEST(CentralNodeTurns, StreamsTakeTurnsUntilTheirFramesAreDone)
{
  const CodedStream stream = streamOf(6);
  Gate gate;
  std::string served; // written by the one thread, as the numbers
  std::map<std::string, std::uint32_t> last_number;
  CentralNode node(settingsOfOneThread(), [&](const ReceivedFrame& frame) {
    if (frame.stream == "blocked") {
      gate.pass();
      return;
    }
    EXPECT_TRUE(frame.status.ok());
    EXPECT_EQ(frame.statistics.frame_number, ++last_number[frame.stream]);
    served += frame.stream;
  });
  node.addStream("blocked");
  send(node, "blocked", Bytes());
  gate.waitForArrivals(1);
  for (const auto& [name, frames] :
       std::map<std::string, std::size_t>{{"a", 6}, {"b", 2}, {"c", 1}, {"d", 4}}) {
    node.addStream(name);
    for (std::size_t i = 0; i < frames; ++i)
      send(node, name, stream.frames[i]);
  }
  gate.open();
  node.waitUntilDecoded();
  EXPECT_EQ(served,
            "abcd"
            "abd"
            "ad"
            "ad"
            "a"
            "a");
}

} // namespace
