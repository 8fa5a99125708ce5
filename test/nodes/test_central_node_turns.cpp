/** \file
 * \brief The order in which a CentralNode decodes waiting frames: streams take turns.
 */
#include <pcl_ext/nodes/central_node.h>

#include "support/central_streams.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

namespace {

using namespace pcl_ext::nodes;
using namespace pcl_ext::nodes::test;

CentralNodeSettings
settingsOfOneThread()
{
  CentralNodeSettings settings = centralSettings();
  settings.threads = 1;
  return settings;
}

TEST(CentralNodeTurns, ALightStreamDoesNotWaitBehindAllFramesOfAHeavyOne)
{
  const CodedStream stream = streamOf(40);
  Gate beginning;
  Gate second_frame;
  std::string served; // written by the one thread
  CentralNode node(settingsOfOneThread(), [&](const ReceivedFrame& frame) {
    served += frame.stream;
    if (served == "H")
      beginning.pass();
    else if (served == "HH")
      second_frame.pass();
  });
  node.addStream("H");
  node.addStream("l");
  for (const Bytes& frame : stream.frames)
    send(node, "H", frame);
  beginning.open();
  // In the middle of the heavy stream's frames, all of which wait.
  second_frame.waitForArrivals(1);
  send(node, "l", stream.frames[0]);
  second_frame.open();
  node.waitUntilDecoded();
  // The heavy stream asks for its next turn when it has ended this one.
  EXPECT_EQ(served, "HHl" + std::string(38, 'H'));
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
