/** \file
 * \brief The order in which a CentralNode decodes waiting frames: streams take turns.
 */
#include <pcl_ext/nodes/central_node.h>

#include "support/central_streams.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::nodes;
using namespace pcl_ext::nodes::test;

/** \brief A node that is blocked until frames of several streams wait, and records the order
 * in which they are decoded. */
class WaitingStreams {
public:
  explicit WaitingStreams(unsigned int threads) : node_(settingsOf(threads), listener())
  {
    // A stream of its own holds each thread.
    for (unsigned int i = 0; i < threads; ++i) {
      node_.addStream("blocked " + std::to_string(i));
      send(node_, "blocked " + std::to_string(i), Bytes());
    }
    gate_.waitForArrivals(threads);
  }

  void
  add(const std::string& name, const std::vector<Bytes>& frames)
  {
    node_.addStream(name);
    for (const Bytes& frame : frames)
      send(node_, name, frame);
  }

  /** \brief The names of the streams in the order in which their frames were served. */
  std::string
  served()
  {
    gate_.open();
    node_.waitUntilDecoded();
    const std::lock_guard<std::mutex> lock(mutex_);
    return served_;
  }

private:
  static CentralNodeSettings
  settingsOf(unsigned int threads)
  {
    CentralNodeSettings settings = centralSettings();
    settings.threads = threads;
    return settings;
  }

  FrameListener
  listener()
  {
    return [this](const ReceivedFrame& frame) {
      if (frame.stream.find("blocked") == 0) {
        gate_.pass();
        return;
      }
      EXPECT_TRUE(frame.status.ok());
      const std::lock_guard<std::mutex> lock(mutex_);
      EXPECT_EQ(frame.statistics.frame_number, ++last_number_[frame.stream]);
      served_ += frame.stream;
    };
  }

  std::mutex mutex_;
  std::string served_;
  std::map<std::string, std::uint32_t> last_number_;
  Gate gate_;
  CentralNode node_; // its threads use what is above
};

TEST(CentralNodeTurns, ALightStreamDoesNotWaitBehindAllFramesOfAHeavyOne)
{
  const CodedStream stream = streamOf(40);
  CentralNodeSettings settings = centralSettings();
  settings.threads = 1;
  Gate beginning;
  Gate second_frame;
  std::string served; // written by the one thread
  CentralNode node(settings, [&](const ReceivedFrame& frame) {
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
  const auto first = [&](std::size_t count) {
    return std::vector<Bytes>(stream.frames.begin(),
                              stream.frames.begin() +
                                  static_cast<std::ptrdiff_t>(count));
  };
  WaitingStreams streams(1);
  streams.add("a", first(6));
  streams.add("b", first(2));
  streams.add("c", first(1));
  streams.add("d", first(4));
  EXPECT_EQ(streams.served(),
            "abcd"
            "abd"
            "ad"
            "ad"
            "a"
            "a");
}

TEST(CentralNodeTurns, AReturningStreamIsServedAfterWaitingOnes)
{
  const CodedStream stream = streamOf(3);
  WaitingStreams streams(1);
  streams.add("a", {stream.frames[0]});
  streams.add("b", {stream.frames[0], stream.frames[1]});
  streams.add("a", {stream.frames[1], stream.frames[2]});
  EXPECT_EQ(streams.served(), "ababa");
}

TEST(CentralNodeTurns, WithSeveralThreadsTheFramesOfAStreamStayInOrder)
{
  const CodedStream stream = streamOf(20);
  WaitingStreams streams(3);
  for (const std::string name : {"a", "b", "c", "d", "e"})
    streams.add(name, stream.frames);
  EXPECT_EQ(streams.served().size(), 5 * 20u); // the listener checks their numbers
}

} // namespace
