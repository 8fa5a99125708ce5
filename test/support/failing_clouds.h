// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "support/failing_frames.h"
#include "support/lidar_room.h"
#include "support/sensor_clouds.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::test::failing_memory {

using namespace nodes;
using nodes::test::cloudSeenFrom;
using nodes::test::messageOf;
using nodes::test::poseOf;
using nodes::test::settingsOf;
using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using Clouds = std::vector<Cloud::Ptr>;
using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;
using Messages = std::vector<pcl::PCLPointCloud2>;

/** \brief Clouds whose extent and number of points change. */
inline Clouds
growingClouds()
{
  Clouds clouds;
  for (const unsigned int i : {0u, 1u, 2u, 3u, 0u}) {
    clouds.push_back(
        randomCloud<pcl::PointXYZI>(i, 60 + 40 * i, {1.0, 1.0, 1.0}, 0.5 + 0.5 * i));
    clouds.back()->header.stamp = 1000 * clouds.size();
    clouds.back()->header.frame_id = long_name;
  }
  return clouds;
}

inline IntensityCompressionSettings
classSettings()
{
  IntensityCompressionSettings settings = settingsWith(0.1);
  settings.i_frame_rate = 3;
  settings.effort = Effort::Fast;
  settings.carry_header = true;
  settings.retain_octree = true;
  return settings;
}

class ClassSender : public Sender {
public:
  explicit ClassSender(const Clouds& clouds) : clouds_(clouds) {}

  bool
  send(std::size_t input, Bytes& bytes) override
  {
    const CompressionStatus status =
        compression_.encodePointCloud(clouds_[input], output_);
    const Exemption exemption;
    const std::string written = output_.str();
    output_.str("");
    output_.clear();
    if (status.ok())
      bytes.assign(written.begin(), written.end());
    // The memory of the output may have run out, too.
    return status.code() != CompressionCode::OutputFailed &&
           isSent(status, CompressionCode::OutOfMemory, bytes);
  }

private:
  const Clouds& clouds_;
  Compression compression_{classSettings()};
  std::ostringstream output_;
};

class ClassReceiver : public Receiver {
public:
  bool
  receive(const Bytes& bytes, Shown& shown) override
  {
    Cloud::Ptr cloud;
    {
      const Exemption exemption;
      cloud.reset(new Cloud);
    }
    const CompressionStatus status =
        compression_.decodePointCloud(bytes.data(), bytes.size(), cloud);
    const Exemption exemption;
    EXPECT_EQ(compression_.getLeafCount(),
              status.ok() ? cloud->size() : compression_.getLeafCount());
    if (!status.ok()) {
      EXPECT_TRUE(cloud->empty());
      return false;
    }
    shown = {compression_.statistics().coding.is_i_frame,
             {},
             cloud->header.stamp,
             cloud->header.frame_id};
    for (const auto& [index, voxel] : naiveVoxels(*cloud, 0.1))
      shown.voxels[index] = voxel.sum;
    return true;
  }

private:
  Compression compression_{classSettings()};
};

class NodeSender : public Sender {
public:
  NodeSender(const SensorNodeSettings& settings, const Messages& clouds)
  : clouds_(clouds), node_(settings)
  {}

  bool
  send(std::size_t input, Bytes& bytes) override
  {
    const SensorNodeStatus status = node_.encode(clouds_[input], poseOf(0), bytes);
    const Exemption exemption;
    const SensorNodeStatistics statistics = node_.statistics();
    if (status.hasFrame()) {
      ++sent_;
      points_ = statistics.preprocessing.points;
    }
    else
      EXPECT_EQ(status.code(), SensorNodeCode::OutOfMemory) << status.message();
    EXPECT_EQ(status.hasFrame(), !bytes.empty());
    EXPECT_EQ(statistics.frames, sent_);
    EXPECT_EQ(statistics.clouds_refused, ++calls_ - sent_);
    EXPECT_EQ(statistics.preprocessing.points, points_); // of the last frame
    return status.hasFrame();
  }

private:
  const Messages& clouds_;
  SensorNode node_;
  std::size_t calls_ = 0;
  std::size_t sent_ = 0;
  std::size_t points_ = 0;
};

/** \brief The sensor stands still; its clouds differ. */
inline Messages
messages()
{
  Messages clouds;
  for (unsigned int frame = 0; frame < 6; ++frame)
    clouds.push_back(messageOf(cloudSeenFrom(poseOf(0), frame + 1, 400, 5), 1000));
  return clouds;
}

/** \brief Of a lidar in snow. */
inline Messages
lidarMessages()
{
  Messages clouds;
  LidarRoom room;
  room.height = 16;
  room.snow = 0.05;
  for (const std::uint32_t width : {60u, 80u, 80u}) {
    room.width = width;
    ++room.seed;
    clouds.push_back(messageOf(room.scan().cloud<Cloud>(), 1000));
  }
  return clouds;
}

inline SensorNodeSettings
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

inline SensorNodeSettings
temporalSettings()
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.compression.temporal_filter = 8;
  settings.crop_box = nodes::test::wide_box;
  return settings;
}

using MakeSender = std::function<std::unique_ptr<Sender>()>;

/** \brief What makes senders of the same inputs; these are the last argument. */
template <typename SenderT, typename InputsT, typename... SettingsT>
MakeSender
sendersOf(InputsT inputs, const SettingsT&... settings)
{
  const auto all = std::make_shared<const InputsT>(std::move(inputs));
  return [all, settings...] { return std::make_unique<SenderT>(settings..., *all); };
}

struct Operation {
  std::string name;
  std::function<MakeSender()> senders; ///< makes the inputs
  std::size_t inputs;
  /** \brief Whether frames do not depend on what was lost before them. */
  bool is_exact = true;
  bool has_class_receiver = false;
  /** \brief Whether frames behind a loss are those of a sender that begins there. */
  bool begins_anew = true;
};

inline std::vector<Operation>
coders()
{
  std::vector<Operation> operations;
  const auto add = [&](const std::string& name, const Coder& kind) {
    operations.push_back(
        {name,
         [kind] { return sendersOf<FrameSender>(framesOf(kind), kind); },
         frame_count});
  };
  // Balanced allocates what small does.
  for (const Effort effort : {Effort::Fast, Effort::Small})
    for (const bool has_depths : {false, true})
      add(nameOf(effort) + (has_depths ? "WithDepths" : ""),
          {StreamFormat::Version1, effort, has_depths});
  add("FramesOfChanges", {StreamFormat::Version1, Effort::Fast, false, true});
  add("Published", {StreamFormat::Published, Effort::Fast, false});
  const auto clouds = [] { return sendersOf<ClassSender>(growingClouds()); };
  operations.push_back({"Class", clouds, 5, true, true});
  return operations;
}

inline std::vector<Operation>
senders()
{
  std::vector<Operation> operations = coders();
  const Coder fast{StreamFormat::Version1, Effort::Fast, false};
  operations.push_back({"Filter",
                        [fast] { return sendersOf<FilterSender>(framesOf(fast)); },
                        frame_count,
                        false});
  const auto addNode = [&](const std::string& name,
                           const SensorNodeSettings& settings,
                           Messages (*clouds)(),
                           std::size_t inputs) {
    operations.push_back({name,
                          [=] { return sendersOf<NodeSender>(clouds(), settings); },
                          inputs,
                          false});
  };
  addNode("Node", removingSettings(IntensityLaw::Quadratic), messages, 6);
  addNode("NodeOfALidar", removingSettings(IntensityLaw::Count), lidarMessages, 3);
  addNode("NodeWithATemporalFilter", temporalSettings(), messages, 6);
  operations.back().begins_anew = false;
  return operations;
}

} // namespace pcl_ext::test::failing_memory
