// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Programs written for pcl::io::OctreePointCloudCompression, compiled for that
 * class and for this library's: only the class name differs.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "support/cloud_streams.h"

// PCL's own class without linking pcl_io, whose coders must be included once a program.
// clang-format off
#include <pcl/compression/octree_pointcloud_compression.h>
#include <pcl/io/impl/octree_pointcloud_compression.hpp>
// clang-format on
#include <pcl/console/print.h>
#include <pcl/memory.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

namespace {

/** \brief The class names that a program may be written with. */
struct PclNames {
  template <typename PointT>
  using Compression = pcl::io::OctreePointCloudCompression<PointT>;
};

struct PclExtNames {
  template <typename PointT>
  using Compression = pcl_ext::io::OctreePointCloudIntensityCompression<PointT>;
};

template <typename NamesT>
class ProgramsForPcl : public ::testing::Test {};

struct NameOfNames {
  template <typename NamesT>
  static std::string
  GetName(int)
  {
    return std::is_same<NamesT, PclNames>::value ? "pcl" : "pcl_ext";
  }
};

using BothNames = ::testing::Types<PclNames, PclExtNames>;
TYPED_TEST_SUITE(ProgramsForPcl, BothNames, NameOfNames);

/** \brief A cloud with one point in each of some voxels of 1 cm, so that both classes
 * decode as many points as went in. */
template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr
sparseCloud(unsigned int frame)
{
  typename pcl::PointCloud<PointT>::Ptr cloud(new pcl::PointCloud<PointT>);
  for (int i = 0; i < 200; ++i) {
    PointT point;
    point.x = 0.034f * static_cast<float>(i % 10) + 0.003f;
    point.y = 0.034f * static_cast<float>(i / 10 % 10) + 0.003f;
    point.z = 0.034f * static_cast<float>(i / 100) + 0.01f * static_cast<float>(frame) +
              0.003f;
    cloud->push_back(point);
  }
  return cloud;
}

/** \brief Largest distance from a point of one cloud to the nearest of the other. */
template <typename PointT>
float
farthestNeighbour(const pcl::PointCloud<PointT>& from,
                  const pcl::PointCloud<PointT>& to)
{
  float farthest = 0.0f;
  for (const PointT& point : from) {
    float nearest = std::numeric_limits<float>::infinity();
    for (const PointT& other : to)
      nearest =
          std::min(nearest, (point.getVector3fMap() - other.getVector3fMap()).norm());
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

constexpr float half_diagonal_of_1_cm = 0.0087f;

/** \brief The program of PCL's tutorial "Point Cloud Compression", its grabber and its
 * viewer replaced by calls. */
template <typename NamesT>
class SimpleOpenNIViewer {
public:
  using Compressor = typename NamesT::template Compression<pcl::PointXYZRGBA>;

  void
  cloud_cb_(const pcl::PointCloud<pcl::PointXYZRGBA>::ConstPtr& cloud)
  {
    // stringstream to store compressed point cloud
    std::stringstream compressedData;
    // output pointcloud
    pcl::PointCloud<pcl::PointXYZRGBA>::Ptr cloudOut(
        new pcl::PointCloud<pcl::PointXYZRGBA>());

    // compress point cloud
    PointCloudEncoder->encodePointCloud(cloud, compressedData);

    // decompress point cloud
    PointCloudDecoder->decodePointCloud(compressedData, cloudOut);

    // show decompressed point cloud
    showCloud(cloudOut);
  }

  void
  run(const std::vector<pcl::PointCloud<pcl::PointXYZRGBA>::Ptr>& grabbed)
  {
    bool showStatistics = true;

    // for a full list of profiles see:
    // /io/include/pcl/compression/compression_profiles.h
    pcl::io::compression_Profiles_e compressionProfile =
        pcl::io::MED_RES_ONLINE_COMPRESSION_WITH_COLOR;

    // instantiate point cloud compression for encoding and decoding
    PointCloudEncoder = new Compressor(compressionProfile, showStatistics);
    PointCloudDecoder = new Compressor();

    // make callback function from member function
    std::function<void(const pcl::PointCloud<pcl::PointXYZRGBA>::ConstPtr&)> f =
        [this](const pcl::PointCloud<pcl::PointXYZRGBA>::ConstPtr& cloud) {
          cloud_cb_(cloud);
        };
    for (const auto& cloud : grabbed)
      f(cloud);

    // delete point cloud compression instances
    delete (PointCloudEncoder);
    delete (PointCloudDecoder);
  }

  void
  showCloud(const pcl::PointCloud<pcl::PointXYZRGBA>::ConstPtr& cloud)
  {
    shown.push_back(cloud);
  }

  std::vector<pcl::PointCloud<pcl::PointXYZRGBA>::ConstPtr> shown;

  Compressor* PointCloudEncoder;
  Compressor* PointCloudDecoder;
};

TYPED_TEST(ProgramsForPcl, TheTutorialRuns)
{
  std::vector<pcl::PointCloud<pcl::PointXYZRGBA>::Ptr> grabbed;
  for (unsigned int frame = 0; frame < 5; ++frame)
    grabbed.push_back(sparseCloud<pcl::PointXYZRGBA>(frame));
  SimpleOpenNIViewer<TypeParam> v;
  ::testing::internal::CaptureStdout();
  v.run(grabbed);
  const std::string printed = ::testing::internal::GetCapturedStdout();
  EXPECT_NE(printed.find("*** POINTCLOUD ENCODING ***"), std::string::npos);
  ASSERT_EQ(v.shown.size(), grabbed.size());
  for (std::size_t i = 0; i < grabbed.size(); ++i) {
    EXPECT_EQ(v.shown[i]->size(), grabbed[i]->size());
    EXPECT_LE(farthestNeighbour(*grabbed[i], *v.shown[i]), half_diagonal_of_1_cm);
    EXPECT_LE(farthestNeighbour(*v.shown[i], *grabbed[i]), half_diagonal_of_1_cm);
  }
}

/** \brief A recorder and player as a user of PCL writes them. */
template <typename NamesT, typename PointT>
void
recordAndPlay()
{
  using Compressor = typename NamesT::template Compression<PointT>;
  using PointCloud = typename Compressor::PointCloud;
  using PointCloudPtr = typename Compressor::PointCloudPtr;
  using PointCloudConstPtr = typename Compressor::PointCloudConstPtr;
  static_assert(std::is_same<PointCloud, pcl::PointCloud<PointT>>::value, "");
  static_assert(
      std::is_same<PointCloudPtr, typename pcl::PointCloud<PointT>::Ptr>::value, "");
  static_assert(std::is_same<PointCloudConstPtr,
                             typename pcl::PointCloud<PointT>::ConstPtr>::value,
                "");

  std::stringstream file;
  {
    typename Compressor::Ptr encoder(new Compressor(
        pcl::io::MANUAL_CONFIGURATION, false, 0.002, 0.01, true, 10, false, 5));
    for (unsigned int frame = 0; frame < 15; ++frame) {
      PointCloudConstPtr cloud = sparseCloud<PointT>(frame);
      encoder->encodePointCloud(cloud, file);
    }
  }
  auto player = pcl::make_shared<Compressor>();
  const typename Compressor::ConstPtr watched = player;
  for (unsigned int frame = 0; frame < 15; ++frame) {
    PointCloudPtr cloud(new PointCloud);
    player->decodePointCloud(file, cloud);
    ASSERT_EQ(watched->getOutputCloud(), cloud);
    EXPECT_EQ(cloud->size(), 200u) << "frame " << frame;
    EXPECT_EQ(cloud->width, 200u);
    EXPECT_EQ(cloud->height, 1u);
    EXPECT_LE(farthestNeighbour(*sparseCloud<PointT>(frame), *cloud),
              half_diagonal_of_1_cm);
  }
}

TYPED_TEST(ProgramsForPcl, ARecorderAndPlayerRunWithEveryPointType)
{
  recordAndPlay<TypeParam, pcl::PointXYZ>();
  recordAndPlay<TypeParam, pcl::PointXYZI>();
  recordAndPlay<TypeParam, pcl::PointXYZRGB>();
  recordAndPlay<TypeParam, pcl::PointXYZRGBA>();
}

TYPED_TEST(ProgramsForPcl, TypesAreWherePclHasThem)
{
  using Compressor = typename TypeParam::template Compression<pcl::PointXYZ>;
  static_assert(
      std::is_same<typename Compressor::Ptr, pcl::shared_ptr<Compressor>>::value, "");
  static_assert(std::is_same<typename Compressor::ConstPtr,
                             pcl::shared_ptr<const Compressor>>::value,
                "");
  // The default base is the double-buffered one.
  static_assert(
      std::is_same<typename Compressor::RealTimeStreamCompression, Compressor>::value,
      "");
  using Single = typename Compressor::SinglePointCloudCompressionLowMemory;
  static_assert(!std::is_same<Single, Compressor>::value, "");
  using LeafNode = typename Compressor::LeafNode;
  using BranchNode = typename Compressor::BranchNode;
  static_assert(std::is_base_of<pcl::octree::OctreeNode, LeafNode>::value, "");
  static_assert(std::is_base_of<pcl::octree::OctreeNode, BranchNode>::value, "");
  static_assert(std::has_virtual_destructor<Compressor>::value, "");
  EXPECT_EQ(Compressor(pcl::io::LOW_RES_OFFLINE_COMPRESSION_WITH_COLOR).getResolution(),
            0.01);
}

TYPED_TEST(ProgramsForPcl, ConstructionIsImplicit)
{
  using Compressor = typename TypeParam::template Compression<pcl::PointXYZ>;
  EXPECT_TRUE((std::is_convertible<pcl::io::compression_Profiles_e, Compressor>::value))
      << "Compression encoder = pcl::io::LOW_RES_ONLINE_COMPRESSION_WITH_COLOR;";
  struct Node {
    Compressor encoder;
  };
  Node node{};
  EXPECT_EQ(node.encoder.getOutputCloud(), nullptr);
  const typename Compressor::PointCloudPtr cloud(new typename Compressor::PointCloud);
  node.encoder.setOutputCloud(cloud);
  EXPECT_EQ(node.encoder.getOutputCloud(), cloud);
}

TYPED_TEST(ProgramsForPcl, ResolutionCanBeSetLater)
{
  typename TypeParam::template Compression<pcl::PointXYZ> encoder(
      pcl::io::MANUAL_CONFIGURATION, false, 0.05, 0.05, true, 30, false);
  encoder.initialization();
  encoder.setResolution(0.5);
  EXPECT_EQ(encoder.getResolution(), 0.5);
  const pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  for (int i = 0; i < 100; ++i)
    cloud->emplace_back(0.1f * static_cast<float>(i) + 0.01f, 0.01f, 0.01f);
  std::stringstream stream;
  encoder.encodePointCloud(cloud, stream);
  pcl::PointCloud<pcl::PointXYZ>::Ptr decoded(new pcl::PointCloud<pcl::PointXYZ>);
  encoder.decodePointCloud(stream, decoded);
  EXPECT_GE(decoded->size(), 20u); // PCL's grid begins at the first point
  EXPECT_LE(decoded->size(), 21u);
}

TYPED_TEST(ProgramsForPcl, LowMemoryVariantCompilesAndEncodesSingleClouds)
{
  using Single = typename TypeParam::template Compression<
      pcl::PointXYZ>::SinglePointCloudCompressionLowMemory;
  if constexpr (std::is_same<TypeParam, PclExtNames>::value) {
    // PCL's does not compile: OctreeBase has no switchBuffers.
    Single compression;
    std::stringstream stream;
    pcl::PointCloud<pcl::PointXYZ>::Ptr decoded(new pcl::PointCloud<pcl::PointXYZ>);
    compression.encodePointCloud(sparseCloud<pcl::PointXYZ>(0), stream);
    compression.decodePointCloud(stream, decoded);
    EXPECT_EQ(decoded->size(), 200u);
  }
  else {
    EXPECT_TRUE((std::is_class<Single>::value));
  }
}
TEST(BeyondPcl, VoxelsAreWherePclPutsThePointsToWithinAVoxel)
{
  // With PCL's own box fitted to the same world lattice, both name the same voxels.
  const auto cloud = pcl_ext::test::randomCloud<pcl::PointXYZ>(1, 2000);
  pcl::io::OctreePointCloudCompression<pcl::PointXYZ> theirs(
      pcl::io::MANUAL_CONFIGURATION, false, 0.0625, 0.0625, true, 10, false);
  theirs.defineBoundingBox(-1.0, -1.0, -1.0, 1.0, 1.0, 1.0);
  pcl_ext::io::OctreePointCloudIntensityCompression<pcl::PointXYZ> ours(
      pcl::io::MANUAL_CONFIGURATION, false, 0.0625, 0.0625, true, 10, false);
  std::stringstream their_stream;
  std::stringstream our_stream;
  theirs.encodePointCloud(cloud, their_stream);
  ours.encodePointCloud(cloud, our_stream);
  EXPECT_LT(our_stream.str().size(), their_stream.str().size());
  pcl::PointCloud<pcl::PointXYZ>::Ptr from_theirs(new pcl::PointCloud<pcl::PointXYZ>);
  pcl::PointCloud<pcl::PointXYZ>::Ptr from_ours(new pcl::PointCloud<pcl::PointXYZ>);
  pcl::io::OctreePointCloudCompression<pcl::PointXYZ> their_decoder;
  their_decoder.decodePointCloud(their_stream, from_theirs);
  ours.decodePointCloud(our_stream, from_ours);
  ASSERT_EQ(from_ours->size(), from_theirs->size());
  EXPECT_LE(farthestNeighbour(*from_ours, *from_theirs), 1e-5f);
  EXPECT_LE(farthestNeighbour(*from_theirs, *from_ours), 1e-5f);
}
} // namespace
