// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "support/cloud_streams.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::test;

using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;

TEST(CompressionThreads, AnInstanceInEachThreadGivesTheBytesOfOneAfterTheOther)
{
  constexpr unsigned int thread_count = 4;
  const auto encode_stream = [](unsigned int seed) {
    IntensityCompressionSettings settings = settingsWith(0.02 + 0.01 * seed);
    settings.i_frame_rate = 3;
    settings.retain_octree = seed % 2 == 0;
    Compression encoder(settings);
    Compression decoder;
    std::string bytes;
    for (unsigned int frame = 0; frame < 10; ++frame) {
      std::stringstream stream;
      encoder.encodePointCloud(randomCloud<pcl::PointXYZI>(seed * 100 + frame, 500),
                               stream);
      bytes += stream.str();
      Cloud::Ptr decoded;
      if (!decoder.decodePointCloud(stream, decoded).ok())
        return std::string("a frame did not decode");
      bytes += std::to_string(decoded->size());
    }
    return bytes;
  };
  std::vector<std::string> serially(thread_count);
  std::vector<std::string> in_threads(thread_count);
  for (unsigned int i = 0; i < thread_count; ++i)
    serially[i] = encode_stream(i);
  std::vector<std::thread> threads;
  for (unsigned int i = 0; i < thread_count; ++i)
    threads.emplace_back([&, i] { in_threads[i] = encode_stream(i); });
  for (std::thread& thread : threads)
    thread.join();
  for (unsigned int i = 0; i < thread_count; ++i) {
    EXPECT_GT(serially[i].size(), 1000u);
    EXPECT_EQ(serially[i], in_threads[i]);
  }
}

} // namespace
