// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "link/followed_stream.h"
#include "view/live_source.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::link;
using pcl_ext::view::test::Bytes;
using pcl_ext::view::test::LiveSource;

class Followed {
public:
  Bytes
  next(bool is_i_frame = false)
  {
    if (is_i_frame)
      source_.requestIFrame();
    return source_.next();
  }

  bool
  arrives(std::uint64_t number,
          const Bytes& bytes,
          std::uint64_t publisher = 7,
          Time time = Time(0))
  {
    const auto frame = wholeFrameOf(bytes.data(), bytes.size());
    EXPECT_TRUE(frame);
    return frame && stream.accept({publisher, number, time}, *frame);
  }

  /** \brief The next frame arrives, an I-frame if one is needed.
   * \return whether it is accepted
   */
  bool
  goesOn()
  {
    ++number_;
    return arrives(number_, next(stream.needsIFrame()));
  }

  void
  expectRecovery(std::size_t frames)
  {
    for (std::size_t i = 0; i < frames; ++i)
      goesOn();
    for (int i = 0; i < 10; ++i)
      EXPECT_TRUE(goesOn());
  }

  FollowedStream stream;

private:
  std::uint64_t number_ = 0;
  LiveSource source_{1000};
};

Bytes
damaged(Bytes bytes)
{
  bytes.back() ^= 1;
  return bytes;
}

TEST(FollowedStream, LeavesOutFramesWhoseChecksumIsWrong)
{
  Followed followed;
  for (int i = 0; i < 5; ++i)
    ASSERT_TRUE(followed.goesOn());
  EXPECT_FALSE(followed.arrives(6, damaged(followed.next())));
  EXPECT_TRUE(followed.stream.needsIFrame());
  EXPECT_FALSE(followed.arrives(7, followed.next())); // it refers to the damaged one
  EXPECT_FALSE(followed.arrives(8, damaged(followed.next(true))));
  EXPECT_TRUE(followed.stream.needsIFrame());
  EXPECT_TRUE(followed.arrives(9, followed.next(true)));
  EXPECT_TRUE(followed.arrives(10, followed.next()));
  EXPECT_EQ(followed.stream.statistics.frames_damaged, 2u);
  EXPECT_EQ(followed.stream.statistics.frames_skipped, 1u);
  EXPECT_EQ(followed.stream.statistics.frames_lost, 0u);
}

TEST(FollowedStream, LeavesOutFramesOfAnotherStreamWithItsNumbers)
{
  Followed followed;
  LiveSource other(1000, 2, 9);
  ASSERT_TRUE(followed.goesOn());
  other.next();
  EXPECT_FALSE(followed.arrives(2, other.next()));
  EXPECT_EQ(followed.stream.statistics.frames_damaged, 1u);
}

TEST(FollowedStream, IsNotStoppedByFramesOfOthers)
{
  Followed followed;
  for (int i = 0; i < 5; ++i)
    ASSERT_TRUE(followed.goesOn());
  LiveSource other(1000, 2, 9);
  const Bytes i_frame = damaged(other.next());
  EXPECT_FALSE(followed.arrives(1, i_frame, 8));
  EXPECT_FALSE(followed.arrives(1000, i_frame));
  EXPECT_FALSE(followed.arrives(2, other.next(), 8)); // a P-frame
  EXPECT_TRUE(followed.goesOn());
  EXPECT_EQ(followed.stream.statistics.frames_damaged, 2u);
  EXPECT_EQ(followed.stream.statistics.publishers, 1u);
}

TEST(FollowedStream, GoesOnAfterOneMessageWithAnyNumber)
{
  constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
  constexpr std::uint64_t one = 1;
  for (const bool is_i_frame : {true, false})
    for (const std::uint64_t number : {most,
                                       most / 2,
                                       one << 32,
                                       (one << 32) - 1,
                                       one << 31,
                                       (one << 31) + 20,
                                       (one << 31) - 1,
                                       one << 30,
                                       one << 24,
                                       one << 20,
                                       one * 100}) {
      SCOPED_TRACE(std::to_string(number) + (is_i_frame ? ", I" : ", P"));
      Followed followed;
      for (int i = 0; i < 20; ++i)
        ASSERT_TRUE(followed.goesOn());
      LiveSource other(1000, 2, 9);
      Bytes bytes = other.next();
      if (!is_i_frame)
        bytes = other.next();
      followed.arrives(number, bytes);
      followed.expectRecovery(6);
      EXPECT_LT(followed.stream.statistics.frames_lost, (one << 24) + 1);
    }
}

TEST(FollowedStream, LeavesOutWhatComesLateOrTwice)
{
  Followed followed;
  std::vector<Bytes> frames;
  for (std::size_t i = 0; i < 40; ++i) {
    frames.push_back(followed.next(i % 10 == 0));
    ASSERT_TRUE(followed.arrives(i + 1, frames[i]));
    EXPECT_FALSE(followed.arrives(i + 1, frames[i]));
  }
  // Also a sequence that is repeated, with I-frames.
  for (std::size_t i = 8; i < 20; ++i)
    EXPECT_FALSE(followed.arrives(i + 1, frames[i]));
  EXPECT_TRUE(followed.arrives(41, followed.next()));
  EXPECT_EQ(followed.stream.statistics.frames_late, 52u);
  EXPECT_EQ(followed.stream.statistics.publishers, 1u);
}

TEST(FollowedStream, LeavesOutWhatALostConnectionDeliversAfterTheNext)
{
  Followed followed;
  const auto arrives = [&followed](std::uint64_t number, const Bytes& bytes) {
    return followed.arrives(number, bytes, 7, std::chrono::milliseconds(100 * number));
  };
  std::vector<Bytes> frames;
  for (std::size_t i = 0; i < 60; ++i)
    frames.push_back(followed.next(i % 10 == 0));
  for (std::size_t i = 0; i < 10; ++i)
    ASSERT_TRUE(arrives(i + 1, frames[i]));
  EXPECT_TRUE(arrives(51, frames[50]));
  for (std::size_t i = 10; i < 50; ++i)
    EXPECT_FALSE(arrives(i + 1, frames[i]));
  for (std::size_t i = 51; i < 60; ++i)
    EXPECT_TRUE(arrives(i + 1, frames[i]));
  EXPECT_EQ(followed.stream.statistics.frames_late, 40u);
  EXPECT_EQ(followed.stream.statistics.frames_lost, 40u);
  EXPECT_EQ(followed.stream.statistics.frames_skipped, 0u);
}

TEST(FollowedStream, GoesOnAfterOneMessageOfAnyTime)
{
  using std::chrono::seconds;
  for (const Time time :
       {Time::min(), Time(-1), Time(seconds(3)), Time(seconds(1000)), Time::max()}) {
    SCOPED_TRACE(time.count());
    Followed followed;
    std::uint64_t number = 0;
    const auto goes_on = [&](int count) {
      bool is_accepted = true;
      while (count-- > 0) {
        ++number;
        is_accepted = followed.arrives(number,
                                       followed.next(followed.stream.needsIFrame()),
                                       7,
                                       std::chrono::milliseconds(100 * number));
      }
      return is_accepted;
    };
    ASSERT_TRUE(goes_on(20));
    LiveSource other(1000, 2, 9);
    ASSERT_TRUE(followed.arrives(1u << 20, other.next(), 7, time));
    EXPECT_TRUE(goes_on(20));
  }
}

} // namespace
