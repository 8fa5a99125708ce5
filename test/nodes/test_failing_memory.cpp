// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/failing_clouds.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace {

namespace failing_memory {

using namespace pcl_ext::test::failing_memory;
using pcl_ext::test::Exemption;
using pcl_ext::test::expectFailuresHandled;
using pcl_ext::test::FailingAllocation;

/** \brief What undisturbed senders send of the inputs from one on. */
std::vector<Shown>
shownFrom(std::size_t first, const Operation& operation, const MakeSender& make)
{
  const std::unique_ptr<Sender> sender = make();
  FrameReceiver receiver;
  std::vector<Shown> shown(operation.inputs - first);
  for (std::size_t i = first; i < operation.inputs; ++i) {
    Bytes bytes;
    EXPECT_TRUE(sender->send(i, bytes));
    EXPECT_TRUE(receiver.receive(bytes, shown[i - first]));
  }
  return shown;
}

class FailingMemory : public testing::TestWithParam<Operation> {
protected:
  FailingMemory() : make_(GetParam().senders())
  {
    for (std::size_t i = 0; i <= GetParam().inputs; ++i)
      shown_from_.push_back(shownFrom(i, GetParam(), make_));
  }

  /** \brief Sends all inputs; the n-th allocation of one of them fails. Where all later
   * ones fail, too, it is sent again after that.
   * \return false if it has no n-th allocation
   */
  bool
  sendWithFailure(std::size_t failing_input, std::size_t n, bool do_later_ones_fail)
  {
    const std::unique_ptr<Sender> sender = make_();
    FrameReceiver receiver;
    bool has_failed = false;
    bool is_lost = false;
    const std::size_t next = failing_input + (do_later_ones_fail ? 0 : 1);
    for (std::size_t i = 0; i < GetParam().inputs; ++i) {
      Bytes bytes;
      bool is_sent = false;
      {
        const FailingAllocation failing(i == failing_input ? n : 0, do_later_ones_fail);
        is_sent = sender->send(i, bytes);
        has_failed = has_failed || (i == failing_input && failing.hasFailed());
      }
      if (!is_sent) {
        EXPECT_TRUE(i == failing_input && has_failed);
        is_lost = true;
        if (!do_later_ones_fail)
          continue;
        EXPECT_TRUE(sender->send(i, bytes));
      }
      Shown shown;
      EXPECT_TRUE(receiver.receive(bytes, shown));
      if (is_lost) {
        // As of a sender that begins there, whose first frame is an I-frame.
        const Shown& expected = shown_from_[next][i - next];
        EXPECT_EQ(shown.is_i_frame, expected.is_i_frame);
        EXPECT_EQ(shown.voxels.empty(), expected.voxels.empty());
        if (GetParam().begins_anew)
          expectSame(shown, expected);
      }
      else if (!has_failed || GetParam().is_exact)
        expectSame(shown, shown_from_[0][i]);
    }
    return has_failed;
  }

  MakeSender make_;
  std::vector<std::vector<Shown>> shown_from_; ///< by the first input
};

TEST_P(FailingMemory, IsReportedAndTheStreamGoesOnWithAnIFrame)
{
  expectFailuresHandled(GetParam().inputs,
                        [&](std::size_t input, std::size_t n, bool do_later_ones_fail) {
                          return sendWithFailure(input, n, do_later_ones_fail);
                        });
}

INSTANTIATE_TEST_SUITE_P(Of,
                         FailingMemory,
                         testing::ValuesIn(senders()),
                         [](const auto& operation) { return operation.param.name; });

class FailingMemoryOfReceivers : public FailingMemory {
protected:
  FailingMemoryOfReceivers() : bytes_(GetParam().inputs)
  {
    const std::unique_ptr<Sender> sender = make_();
    for (std::size_t i = 0; i < bytes_.size(); ++i)
      EXPECT_TRUE(sender->send(i, bytes_[i]));
  }

  std::unique_ptr<Receiver>
  receiver() const
  {
    if (GetParam().has_class_receiver)
      return std::make_unique<ClassReceiver>();
    return std::make_unique<FrameReceiver>();
  }

  bool
  receive(Receiver& receiver, std::size_t frame) const
  {
    Shown shown;
    if (!receiver.receive(bytes_[frame], shown))
      return false;
    const Exemption exemption;
    expectSame(shown, shown_from_[0][frame]);
    return true;
  }

  bool
  receiveWithFailure(Receiver& receiver,
                     std::size_t frame,
                     std::size_t n,
                     bool do_later_ones_fail,
                     bool& has_failed) const
  {
    const FailingAllocation failing(n, do_later_ones_fail);
    const bool is_known = receive(receiver, frame);
    has_failed = failing.hasFailed();
    return is_known;
  }

  bool
  isIFrame(std::size_t frame) const
  {
    return shown_from_[0][frame].is_i_frame;
  }

  std::vector<Bytes> bytes_;
};

TEST_P(FailingMemoryOfReceivers, NeverGivesAWrongFrame)
{
  const auto run = [&](std::size_t frame, std::size_t n, bool do_later_ones_fail) {
    const std::unique_ptr<Receiver> receiver = this->receiver();
    for (std::size_t i = 0; i < frame; ++i)
      EXPECT_TRUE(receive(*receiver, i));
    bool has_failed = false;
    bool is_known =
        receiveWithFailure(*receiver, frame, n, do_later_ones_fail, has_failed);
    EXPECT_TRUE(is_known || has_failed);
    // A sender may send the frame again.
    is_known = is_known || receive(*receiver, frame);
    for (std::size_t i = frame + 1; i < bytes_.size(); ++i) {
      const bool must_be_known = is_known || isIFrame(i);
      is_known = receive(*receiver, i);
      EXPECT_TRUE(is_known || !must_be_known) << i;
    }
    return has_failed;
  };
  expectFailuresHandled(GetParam().inputs, run);
}

INSTANTIATE_TEST_SUITE_P(Of,
                         FailingMemoryOfReceivers,
                         testing::ValuesIn(coders()),
                         [](const auto& operation) { return operation.param.name; });

} // namespace failing_memory

} // namespace
