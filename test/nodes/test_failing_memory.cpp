// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Encoders, decoders, the compression class and a SensorNode while memory runs
 * out.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/filters/temporal_voxel_filter.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "support/changing_frames.h"
#include "support/lidar_room.h"
#include "support/sensor_clouds.h"
#include "support/test_memory.h"
#include "support/voxel_streams.h"
#include "support/world_voxels.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace {

namespace failing_memory {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using namespace pcl_ext::nodes;
using namespace pcl_ext::nodes::test;
using pcl_ext::IntensityLaw;
using pcl_ext::test::Exemption;
using pcl_ext::test::FailingAllocation;
using pcl_ext::test::WorldVoxels;
using pcl_ext::test::worldVoxels;
using Bytes = std::vector<std::uint8_t>;
using Frames = std::vector<VoxelFrame>;
using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using Clouds = std::vector<Cloud::Ptr>;
using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;
using Messages = std::vector<pcl::PCLPointCloud2>;

// Too long for a string's own memory.
const std::string long_name = "a frame whose name has a length";

struct Shown {
  bool is_i_frame = false;
  WorldVoxels voxels;
  std::uint64_t stamp = 0;
  std::string frame_id;
};

void
expectSame(const Shown& shown, const Shown& expected)
{
  EXPECT_EQ(shown.voxels, expected.voxels);
  EXPECT_EQ(shown.stamp, expected.stamp);
  EXPECT_EQ(shown.frame_id, expected.frame_id);
}

/** \brief A sender: sends one of its inputs; false if memory ran out, and there are no
 * bytes then. */
using Send = std::function<bool(std::size_t input, Bytes& bytes)>;

/** \brief Makes senders of the same inputs. */
using MakeSender = std::function<Send()>;

/** \brief A receiver: false if memory ran out or the frame lacks its reference. */
using Receive = std::function<bool(const Bytes& bytes, Shown& shown)>;

bool
isSent(const CompressionStatus& status, const Bytes& bytes)
{
  const Exemption exemption;
  EXPECT_EQ(status.ok(), !bytes.empty());
  EXPECT_TRUE(status.ok() || status.code() == CompressionCode::OutOfMemory)
      << status.message();
  return status.ok();
}

Receive
frameReceiver()
{
  const auto decoder = std::make_shared<FrameDecoder>();
  return [decoder](const Bytes& bytes, Shown& shown) {
    VoxelFrame frame;
    const CompressionStatus status = decoder->decode(bytes.data(), bytes.size(), frame);
    const Exemption exemption;
    if (!status.ok()) {
      EXPECT_TRUE(frame.keys.empty() && frame.intensities.empty());
      EXPECT_TRUE(status.code() == CompressionCode::OutOfMemory ||
                  status.code() == CompressionCode::MissingReference)
          << status.message();
      return false;
    }
    shown = {decoder->statistics().is_i_frame, worldVoxels(frame), 0, {}};
    if (decoder->stamp()) {
      shown.stamp = decoder->stamp()->stamp;
      shown.frame_id = decoder->stamp()->frame_id;
    }
    return true;
  };
}

struct Coder {
  StreamFormat format;
  Effort effort;
  bool has_depth_model = false;
  bool has_frames_of_changes = false;
};

// An I-frame, P-frames with and behind an empty one, an I-frame, and one behind it.
constexpr std::size_t frame_count = 6;

/** \brief Frames, one without voxels among them. */
Frames
framesOf(const Coder& kind)
{
  Frames frames;
  ChangingFrames changing(8);
  RoomStream room(roomSettings(5, 8, kind.has_depth_model));
  for (std::size_t i = 0; i < frame_count; ++i)
    frames.push_back(kind.has_frames_of_changes ? changing.next(i == 1 ? 3000 : 30)
                                                : room.next());
  if (!kind.has_frames_of_changes)
    clearVoxels(frames[2]);
  return frames;
}

MakeSender
frameSenders(const Coder& kind)
{
  const auto frames = std::make_shared<const Frames>(framesOf(kind));
  return [=]() -> Send {
    const auto encoder = std::make_shared<FrameEncoder>(kind.format, 4, kind.effort);
    return [=](std::size_t input, Bytes& bytes) {
      std::optional<FrameStamp> stamp;
      if (kind.format == StreamFormat::Version1) {
        const Exemption exemption;
        stamp = FrameStamp{1000 + input, long_name + std::to_string(input / 3)};
      }
      const CompressionStatus status = encoder->encode((*frames)[input], stamp, bytes);
      EXPECT_TRUE(status.ok() || encoder->isIFrameDue());
      return isSent(status, bytes);
    };
  };
}

/** \brief Of a temporal filter before an encoder; it throws where memory runs out. */
MakeSender
filterSenders()
{
  const auto frames =
      std::make_shared<const Frames>(framesOf({StreamFormat::Version1, Effort::Fast}));
  return [=]() -> Send {
    const auto filter = std::make_shared<pcl_ext::TemporalVoxelFilter>();
    const auto encoder =
        std::make_shared<FrameEncoder>(StreamFormat::Version1, 30, Effort::Fast);
    return [=](std::size_t input, Bytes& bytes) {
      std::optional<VoxelFrame> frame;
      {
        const Exemption exemption;
        frame = (*frames)[input];
      }
      try {
        EXPECT_TRUE(filter->filter(*frame).ok());
      }
      catch (const std::bad_alloc&) {
        encoder->requestIFrame();
        return false;
      }
      const Exemption exemption;
      bytes = pcl_ext::io::test::encoded(*encoder, *frame);
      return true;
    };
  };
}

/** \brief Clouds whose extent and number of points change. */
Clouds
growingClouds()
{
  Clouds clouds;
  for (const unsigned int i : {0u, 1u, 3u, 0u}) {
    clouds.push_back(pcl_ext::test::randomCloud<pcl::PointXYZI>(
        i, 60 + 40 * i, {1.0, 1.0, 1.0}, 0.5 + 0.5 * i));
    clouds.back()->header.stamp = 1000 * clouds.size();
    clouds.back()->header.frame_id = long_name;
  }
  return clouds;
}

IntensityCompressionSettings
classSettings()
{
  IntensityCompressionSettings settings = pcl_ext::test::settingsWith(0.1);
  settings.i_frame_rate = 3;
  settings.effort = Effort::Fast;
  settings.carry_header = true;
  settings.retain_octree = true;
  return settings;
}

MakeSender
classSenders()
{
  const Clouds clouds = growingClouds();
  return [clouds]() -> Send {
    const auto compression = std::make_shared<Compression>(classSettings());
    const auto output = std::make_shared<std::ostringstream>();
    return [=](std::size_t input, Bytes& bytes) {
      const CompressionStatus status =
          compression->encodePointCloud(clouds[input], *output);
      const Exemption exemption;
      const std::string written = output->str();
      output->str("");
      output->clear();
      if (status.ok())
        bytes.assign(written.begin(), written.end());
      // The memory of the output may have run out, too.
      return status.code() != CompressionCode::OutputFailed && isSent(status, bytes);
    };
  };
}

Receive
classReceiver()
{
  const auto compression = std::make_shared<Compression>(classSettings());
  return [compression](const Bytes& bytes, Shown& shown) {
    Cloud::Ptr cloud;
    {
      const Exemption exemption;
      cloud.reset(new Cloud);
    }
    const CompressionStatus status =
        compression->decodePointCloud(bytes.data(), bytes.size(), cloud);
    const Exemption exemption;
    EXPECT_EQ(compression->getLeafCount(),
              status.ok() ? cloud->size() : compression->getLeafCount());
    if (!status.ok()) {
      EXPECT_TRUE(cloud->empty());
      return false;
    }
    shown = {compression->statistics().coding.is_i_frame,
             {},
             cloud->header.stamp,
             cloud->header.frame_id};
    for (const auto& [index, voxel] : pcl_ext::test::naiveVoxels(*cloud, 0.1))
      shown.voxels[index] = voxel.sum;
    return true;
  };
}

MakeSender
nodeSenders(const SensorNodeSettings& settings, Messages messages)
{
  const auto clouds = std::make_shared<const Messages>(std::move(messages));
  return [=]() -> Send {
    const auto node = std::make_shared<SensorNode>(settings);
    return [=, calls = std::size_t{0}, sent = std::size_t{0}, points = std::size_t{0}](
               std::size_t input, Bytes& bytes) mutable {
      const SensorNodeStatus status = node->encode((*clouds)[input], poseOf(0), bytes);
      const Exemption exemption;
      const SensorNodeStatistics statistics = node->statistics();
      if (status.hasFrame()) {
        ++sent;
        points = statistics.preprocessing.points;
      }
      EXPECT_TRUE(status.hasFrame() || status.code() == SensorNodeCode::OutOfMemory)
          << status.message();
      EXPECT_EQ(status.hasFrame(), !bytes.empty());
      EXPECT_EQ(statistics.frames, sent);
      EXPECT_EQ(statistics.clouds_refused, ++calls - sent);
      EXPECT_EQ(statistics.preprocessing.points, points); // of the last frame
      return status.hasFrame();
    };
  };
}

/** \brief The sensor stands still; its clouds differ. */
Messages
cloudsOfACamera()
{
  Messages clouds;
  for (unsigned int frame = 0; frame < 4; ++frame)
    clouds.push_back(messageOf(cloudSeenFrom(poseOf(0), frame + 1, 400, 5), 1000));
  return clouds;
}

/** \brief Of a lidar in snow. */
Messages
cloudsOfALidar()
{
  Messages clouds;
  pcl_ext::test::LidarRoom room;
  room.height = 16;
  room.snow = 0.05;
  for (const std::uint32_t width : {60u, 80u, 80u}) {
    room.width = width;
    ++room.seed;
    clouds.push_back(messageOf(room.scan().cloud<Cloud>(), 1000));
  }
  return clouds;
}

SensorNodeSettings
removingSettings(IntensityLaw law)
{
  SensorNodeSettings settings = settingsOf(law);
  settings.carry_header = true;
  settings.global_frame = long_name;
  settings.outlier_removal.emplace();
  if (law == IntensityLaw::Quadratic) {
    settings.crop_box = BoundingBox{{-1, -1, -1}, {1, 1, 1}};
    settings.outlier_removal->min_log_odds = -1.0f;
  }
  return settings;
}

SensorNodeSettings
temporalSettings()
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.compression.temporal_filter = 8;
  settings.crop_box = wide_box;
  return settings;
}

struct Operation {
  std::string name;
  std::function<MakeSender()> senders; ///< makes the inputs
  std::size_t inputs;
  /** \brief Whether frames do not depend on what was lost before them. */
  bool is_exact = true;
  std::function<Receive()> receiver = frameReceiver;
  /** \brief Whether frames behind a loss are those of a sender that begins there. */
  bool begins_anew = true;
};

std::vector<Operation>
coders()
{
  std::vector<Operation> operations;
  const auto add = [&](const std::string& name, const Coder& kind) {
    operations.push_back({name, [kind] { return frameSenders(kind); }, frame_count});
  };
  // Balanced allocates what small does.
  add("Fast", {StreamFormat::Version1, Effort::Fast});
  add("FastWithDepths", {StreamFormat::Version1, Effort::Fast, true});
  add("Small", {StreamFormat::Version1, Effort::Small});
  add("SmallWithDepths", {StreamFormat::Version1, Effort::Small, true});
  add("FramesOfChanges", {StreamFormat::Version1, Effort::Fast, false, true});
  add("Published", {StreamFormat::Published, Effort::Fast});
  operations.push_back({"Class", classSenders, 4, true, classReceiver});
  return operations;
}

std::vector<Operation>
senders()
{
  std::vector<Operation> operations = coders();
  operations.push_back({"Filter", filterSenders, frame_count, false});
  operations.push_back({"Node",
                        [] {
                          return nodeSenders(removingSettings(IntensityLaw::Quadratic),
                                             cloudsOfACamera());
                        },
                        4,
                        false});
  operations.push_back({"NodeOfALidar",
                        [] {
                          return nodeSenders(removingSettings(IntensityLaw::Count),
                                             cloudsOfALidar());
                        },
                        3,
                        false});
  operations.push_back(
      {"NodeWithATemporalFilter",
       [] { return nodeSenders(temporalSettings(), cloudsOfACamera()); },
       4,
       false,
       frameReceiver,
       false});
  return operations;
}

class FailingMemory : public testing::TestWithParam<Operation> {
protected:
  FailingMemory() : make_(GetParam().senders())
  {
    for (std::size_t i = 0; i <= GetParam().inputs; ++i)
      shown_from_.push_back(shownFrom(i));
  }

  /** \brief What an undisturbed sender sends of the inputs from one on. */
  std::vector<Shown>
  shownFrom(std::size_t first) const
  {
    const Send send = make_();
    const Receive receive = frameReceiver();
    std::vector<Shown> shown(GetParam().inputs - first);
    for (std::size_t i = first; i < GetParam().inputs; ++i) {
      Bytes bytes;
      EXPECT_TRUE(send(i, bytes));
      EXPECT_TRUE(receive(bytes, shown[i - first]));
    }
    return shown;
  }

  /** \brief Sends all inputs; the n-th allocation of one of them fails. Where all later
   * ones fail, too, it is sent again after that.
   * \return false if it has no n-th allocation
   */
  bool
  sendWithFailure(std::size_t failing_input, std::size_t n, bool do_later_ones_fail)
  {
    const Send send = make_();
    const Receive receive = frameReceiver();
    bool has_failed = false;
    bool is_lost = false;
    const std::size_t next = failing_input + (do_later_ones_fail ? 0 : 1);
    for (std::size_t i = 0; i < GetParam().inputs; ++i) {
      Bytes bytes;
      bool is_sent = false;
      {
        const FailingAllocation failing(i == failing_input ? n : 0, do_later_ones_fail);
        is_sent = send(i, bytes);
        has_failed = has_failed || (i == failing_input && failing.hasFailed());
      }
      if (!is_sent) {
        EXPECT_TRUE(i == failing_input && has_failed);
        is_lost = true;
        if (!do_later_ones_fail)
          continue;
        EXPECT_TRUE(send(i, bytes));
      }
      Shown shown;
      EXPECT_TRUE(receive(bytes, shown));
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
  pcl_ext::test::expectFailuresHandled(
      GetParam().inputs,
      [&](std::size_t input, std::size_t n, bool do_later_ones_fail) {
        return sendWithFailure(input, n, do_later_ones_fail);
      });
}

INSTANTIATE_TEST_SUITE_P(Of,
                         FailingMemory,
                         testing::ValuesIn(senders()),
                         [](const auto& operation) { return operation.param.name; });

class FailingMemoryOfReceivers : public FailingMemory {};

TEST_P(FailingMemoryOfReceivers, NeverGivesAWrongFrame)
{
  std::vector<Bytes> frames(GetParam().inputs);
  const Send send = make_();
  for (std::size_t i = 0; i < frames.size(); ++i)
    EXPECT_TRUE(send(i, frames[i]));
  const auto is_right = [&](const Receive& receive, std::size_t frame) {
    Shown shown;
    if (!receive(frames[frame], shown))
      return false;
    const Exemption exemption;
    expectSame(shown, shown_from_[0][frame]);
    return true;
  };
  const auto run = [&](std::size_t frame, std::size_t n, bool do_later_ones_fail) {
    const Receive receive = GetParam().receiver();
    for (std::size_t i = 0; i < frame; ++i)
      EXPECT_TRUE(is_right(receive, i));
    bool is_known = false;
    bool has_failed = false;
    {
      const FailingAllocation failing(n, do_later_ones_fail);
      is_known = is_right(receive, frame);
      has_failed = failing.hasFailed();
    }
    EXPECT_TRUE(is_known || has_failed);
    // A sender may send the frame again.
    is_known = is_known || is_right(receive, frame);
    for (std::size_t i = frame + 1; i < frames.size(); ++i) {
      const bool must_be_known = is_known || shown_from_[0][i].is_i_frame;
      is_known = is_right(receive, i);
      EXPECT_TRUE(is_known || !must_be_known) << i;
    }
    return has_failed;
  };
  pcl_ext::test::expectFailuresHandled(GetParam().inputs, run);
}

INSTANTIATE_TEST_SUITE_P(Of,
                         FailingMemoryOfReceivers,
                         testing::ValuesIn(coders()),
                         [](const auto& operation) { return operation.param.name; });

} // namespace failing_memory

} // namespace
