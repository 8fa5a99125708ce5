// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "bytes/byte_writer.h"
#include "codec/published/entropy_coder.h"
#include "support/published_streams.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <utility>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::published;
using namespace pcl_ext::io::test;
using pcl_ext::PublishedReference;
using pcl_ext::PublishedReferenceDecoder;

/** \brief A stream of PCL's octree, which starts with a box, and its decoders. */
class GrowingStream {
public:
  /** \param[in] box of no size unless given */
  GrowingStream(double resolution,
                unsigned int i_frame_rate,
                const BoundingBox& box = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}})
  : reference_(resolution, corner(box.min), corner(box.max), i_frame_rate)
  , encoder_(StreamFormat::Published, i_frame_rate)
  {}

  /** \brief Sends a cloud: PCL's octree to the library, and what comes of it back to
   * PCL's octree. */
  void
  send(const Cloud& cloud)
  {
    const std::string bytes = reference_.encode(cloud);
    const Cloud expected = reference_decoder_.decode(bytes);
    ASSERT_EQ(expected.size(), reference_.leafCount());
    ASSERT_EQ(decoded(decoder_, bytesOf(bytes), frame_), CompressionCode::Ok);
    EXPECT_EQ(decoder_.statistics().bytes, bytes.size());
    EXPECT_TRUE(isConsistent(frame_));
    expectSameCloud(frame_, expected);
    expectSameCloud(frame_, decoder_of_ours_.decode(textOf(encoded(encoder_, frame_))));
    p_frames_ += decoder_.statistics().is_i_frame ? 0 : 1;
    empty_branches_ += reference_.hasEmptyBranch() ? 1 : 0;
  }

  /** \brief As the authors' program does it: nothing is sent. */
  void
  sendEmptyCloud()
  {
    reference_.restart();
  }

  std::size_t
  pFrames() const
  {
    return p_frames_;
  }

  /** \brief Frames with a branch that has no voxel below it. */
  std::size_t
  emptyBranches() const
  {
    return empty_branches_;
  }

private:
  PublishedReference reference_;
  PublishedReferenceDecoder reference_decoder_;
  PublishedReferenceDecoder decoder_of_ours_;
  FrameEncoder encoder_;
  FrameDecoder decoder_;
  VoxelFrame frame_;
  std::size_t p_frames_ = 0;
  std::size_t empty_branches_ = 0;
};

const BoundingBox boxes[] = {{{-1.9, -1.9, 0.0}, {1.9, 1.9, 1.9}},
                             {{0.3, 0.4, 0.5}, {3.0, 2.5, 1.0}},
                             {{-5.0, 7.0, -9.0}, {-4.5, 7.5, -8.5}},
                             {{-0.03, -0.03, -0.03}, {0.03, 0.03, 0.03}}};

/** \brief True if a box reaches out of the two voxels of 4 cm that PCL makes of
 * none. */
bool
growsOctree(const BoundingBox& box)
{
  return box.min[0] < -0.04 || box.max[0] > 0.04;
}

TEST(PublishedGrowth, OctreesThatGrowRepeatedly)
{
  std::mt19937_64 random(2);
  GrowingStream stream(0.1, 100);
  double reach = 0.05;
  for (int i = 0; i < 60; ++i) {
    // Every fifth frame has nothing but points outside of the octree.
    const bool grows = i % 5 == 0;
    reach *= grows ? 2.0 : 1.0;
    const double corner = grows ? 0.9 * reach : -reach;
    const BoundingBox box{{corner, corner, corner}, {reach, reach, reach}};
    ASSERT_NO_FATAL_FAILURE(stream.send(randomCloud(random, box, 50))) << "frame " << i;
  }
  EXPECT_GT(stream.pFrames(), 30u);
  EXPECT_GT(stream.emptyBranches(), 5u);
}

TEST(PublishedGrowth, OctreesGrowFromAnEmptyBoxAndEmptyCloudsRestartThem)
{
  std::mt19937_64 random(3);
  for (const BoundingBox& box : boxes)
    for (const int period : {0, 2, 3, 7}) // of empty clouds
      for (const unsigned int rate : {1u, 4u, 100u}) {
        GrowingStream stream(0.04, rate);
        Cloud cloud = randomCloud(random, box, 200);
        for (int i = 0; i < 12; ++i) {
          if (period > 0 && i % period == period - 1)
            stream.sendEmptyCloud();
          else
            ASSERT_NO_FATAL_FAILURE(stream.send(cloud)) << "frame " << i;
          shake(random, box, cloud);
        }
        EXPECT_EQ(stream.pFrames() > 0, rate > 1 && period != 2);
        EXPECT_EQ(stream.emptyBranches() > 0, growsOctree(box));
        EXPECT_EQ(stream.emptyBranches() > 1, growsOctree(box) && period > 0);
      }
}

TEST(PublishedGrowth, TheBranchWithoutVoxelsIsWithinTheLimit)
{
  DecoderLimits limits;
  limits.max_voxels = 1;
  for (int doublings = 0; doublings < 20; ++doublings) {
    pcl::PointXYZI point;
    point.x = point.y = point.z = static_cast<float>(1 << doublings) - 0.5f;
    point.intensity = 3.0f;
    Cloud cloud;
    cloud.push_back(point);
    PublishedReference reference(
        1.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), 1);
    const Bytes bytes = bytesOf(reference.encode(cloud));
    FrameDecoder decoder(limits);
    VoxelFrame back;
    ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok) << doublings;
    EXPECT_EQ(back.size(), 1u);
    EXPECT_EQ(reference.hasEmptyBranch(), doublings > 0);
    limits.max_voxels = 0;
    FrameDecoder strict(limits);
    EXPECT_EQ(decoded(strict, bytes, back), CompressionCode::LimitExceeded);
    limits.max_voxels = 1;
  }
}

// ------------------------------------------------- branches without voxels anywhere

/** \brief Makes frames of random octrees, in which any branch may lack voxels. */
class RandomTrees {
public:
  RandomTrees(std::uint64_t seed, unsigned int depth) : random_(seed), depth_(depth) {}

  Bytes
  next(bool is_i_frame)
  {
    last_ = is_i_frame ? Branches() : std::move(current_);
    current_.clear();
    symbols_.clear();
    voxels_ = 0;
    addBranch(0, 1);
    return bytes(is_i_frame);
  }

  std::size_t
  voxels() const
  {
    return voxels_;
  }

private:
  // Occupancy by the path to the branch, with a bit above it that marks its length.
  using Branches = std::map<std::uint64_t, std::uint8_t>;

  void
  addBranch(unsigned int level, std::uint64_t branch)
  {
    const std::uint64_t mask = below(random_, 3) == 0 ? 0 : random_() & random_();
    const auto occupancy = static_cast<std::uint8_t>(mask);
    const auto before = last_.find(branch);
    symbols_.push_back(static_cast<std::uint8_t>(
        occupancy ^ (before == last_.end() ? 0 : before->second)));
    current_[branch] = occupancy;
    for (std::uint64_t child = 0; child < 8; ++child)
      if ((occupancy >> child & 1) != 0) {
        if (level + 1 == depth_)
          ++voxels_;
        else
          addBranch(level + 1, branch << 3 | child);
      }
  }

  Bytes
  bytes(bool is_i_frame)
  {
    Bytes bytes = bytesOf("<HEAD>");
    ByteWriter writer(bytes);
    writer.u32(++frame_number_);
    writer.u8(is_i_frame ? 1 : 0);
    if (is_i_frame) {
      writer.u64(voxels_);
      writer.f64(0.5);
      for (int i = 0; i < 3; ++i)
        writer.f64(-1.0);
      for (int i = 0; i < 3; ++i)
        writer.f64(-1.0 + 0.5 * static_cast<double>(1 << depth_));
    }
    writer.u64(symbols_.size());
    encodeStaticRange(symbols_, bytes);
    Bytes intensities(voxels_);
    for (std::uint8_t& intensity : intensities)
      intensity = static_cast<std::uint8_t>(random_());
    writer.u64(voxels_);
    encodeStaticRange(intensities, bytes);
    return bytes;
  }

  std::mt19937_64 random_;
  unsigned int depth_;
  Branches last_;
  Branches current_;
  Bytes symbols_;
  std::size_t voxels_ = 0;
  std::uint32_t frame_number_ = 0;
};

TEST(PublishedGrowth, BranchesWithoutVoxelsAreReadAsPclReadsThem)
{
  std::size_t frames_of_none = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    RandomTrees trees(seed, static_cast<unsigned int>(1 + seed % 5));
    PublishedReferenceDecoder reference;
    FrameDecoder decoder;
    VoxelFrame back;
    for (int i = 0; i < 12; ++i) {
      const Bytes bytes = trees.next(i % 6 == 0);
      ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok)
          << "seed " << seed << ", frame " << i;
      EXPECT_EQ(back.size(), trees.voxels());
      EXPECT_TRUE(isConsistent(back));
      expectSameCloud(back, reference.decode(textOf(bytes)));
      frames_of_none += back.keys.empty() ? 1 : 0;
    }
  }
  EXPECT_GT(frames_of_none, 0u);
}

} // namespace
