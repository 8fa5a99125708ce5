// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/impl/point_intensity.h>

#include "support/status_codes.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <type_traits>

namespace pcl_ext::test {

inline constexpr double usual_resolution = 0.04;

/** \brief Lattice index of a voxel: it covers [i d_v, (i + 1) d_v) on each axis. */
using VoxelIndex = std::array<std::int64_t, 3>;

struct NaiveVoxel {
  double sum = 0.0;
  std::size_t count = 0;

  double
  mean() const
  {
    return sum / static_cast<double>(count);
  }
};

using NaiveVoxels = std::map<VoxelIndex, NaiveVoxel>;

template <typename PointT>
VoxelIndex
voxelOf(const PointT& point, double resolution)
{
  const auto index = [resolution](float coordinate) {
    return static_cast<std::int64_t>(
        std::floor(static_cast<double>(coordinate) / resolution));
  };
  return {index(point.x), index(point.y), index(point.z)};
}

inline float
centreOf(std::int64_t index, double resolution)
{
  return static_cast<float>((static_cast<double>(index) + 0.5) * resolution);
}

/** \brief Voxelizes with an intensity for each point; points that are not finite are
 * left out. */
template <typename PointT, typename IntensityOfPoint>
NaiveVoxels
naiveVoxels(const pcl::PointCloud<PointT>& cloud,
            double resolution,
            IntensityOfPoint intensity_of)
{
  NaiveVoxels voxels;
  for (const PointT& point : cloud) {
    if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z))
      continue;
    NaiveVoxel& voxel = voxels[voxelOf(point, resolution)];
    voxel.sum += static_cast<double>(intensity_of(point));
    ++voxel.count;
  }
  return voxels;
}

template <typename PointT>
NaiveVoxels
naiveVoxels(const pcl::PointCloud<PointT>& cloud, double resolution)
{
  return naiveVoxels(cloud, resolution, [](const PointT& point) {
    return pcl_ext::nativeIntensity(point, 1.0f);
  });
}

/** \brief A cloud with several points in most voxels, whole-number intensities 0..255.
 * \param[in] centre middle of the cloud, metres
 * \param[in] half_width half its edge, metres
 */
template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr
randomCloud(unsigned int seed,
            std::size_t size,
            const std::array<double, 3>& centre = {0.0, 0.0, 0.0},
            double half_width = 0.5)
{
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> offset(-half_width, half_width);
  std::uniform_int_distribution<int> intensity(0, 255);
  typename pcl::PointCloud<PointT>::Ptr cloud(new pcl::PointCloud<PointT>);
  for (std::size_t i = 0; i < size; ++i) {
    PointT point;
    point.x = static_cast<float>(centre[0] + offset(generator));
    point.y = static_cast<float>(centre[1] + offset(generator));
    point.z = static_cast<float>(centre[2] + offset(generator));
    const int value = intensity(generator);
    if constexpr (pcl_ext::has_intensity_field<PointT>)
      point.intensity = static_cast<decltype(point.intensity)>(value);
    cloud->push_back(point);
  }
  return cloud;
}

/** \brief Expects exactly the centres of the voxels, once each, and a dense row. */
template <typename PointT>
void
expectVoxelCentres(const pcl::PointCloud<PointT>& decoded,
                   const NaiveVoxels& voxels,
                   double resolution)
{
  EXPECT_EQ(decoded.size(), voxels.size());
  EXPECT_EQ(decoded.width, decoded.size());
  EXPECT_EQ(decoded.height, 1u);
  EXPECT_TRUE(decoded.is_dense);
  std::map<VoxelIndex, int> visits;
  for (const PointT& point : decoded) {
    const VoxelIndex index = voxelOf(point, resolution);
    ASSERT_EQ(voxels.count(index), 1u) << point;
    EXPECT_EQ(point.x, centreOf(index[0], resolution));
    EXPECT_EQ(point.y, centreOf(index[1], resolution));
    EXPECT_EQ(point.z, centreOf(index[2], resolution));
    EXPECT_EQ(++visits[index], 1);
  }
}

/** \brief Expects the intensity of each decoded voxel to be what a function makes of
 * the voxel, within a tolerance. */
template <typename PointT, typename IntensityOfVoxel>
void
expectIntensities(const pcl::PointCloud<PointT>& decoded,
                  const NaiveVoxels& voxels,
                  double resolution,
                  IntensityOfVoxel intensity_of,
                  double tolerance)
{
  double worst = 0.0;
  PointT worst_point;
  for (const PointT& point : decoded) {
    const auto voxel = voxels.find(voxelOf(point, resolution));
    ASSERT_NE(voxel, voxels.end()) << point;
    const double error =
        std::abs(static_cast<double>(point.intensity) - intensity_of(voxel->second));
    ASSERT_FALSE(std::isnan(error)) << point;
    if (error > worst) {
      worst = error;
      worst_point = point;
    }
  }
  EXPECT_LE(worst, tolerance) << "the worst point is " << worst_point;
}

inline io::IntensityCompressionSettings
settingsWith(double resolution)
{
  io::IntensityCompressionSettings settings;
  settings.resolution = resolution;
  return settings;
}

/** \brief One frame through an encoder and a decoder, which may have other points. */
template <typename EncoderT, typename DecoderT>
typename std::decay_t<DecoderT>::PointCloudPtr
roundTrip(EncoderT&& encoder,
          DecoderT&& decoder,
          const typename std::decay_t<EncoderT>::PointCloudConstPtr& cloud)
{
  std::stringstream stream;
  const io::CompressionStatus encoded = encoder.encodePointCloud(cloud, stream);
  EXPECT_TRUE(encoded.ok()) << encoded.message();
  typename std::decay_t<DecoderT>::PointCloudPtr decoded;
  const io::CompressionStatus status = decoder.decodePointCloud(stream, decoded);
  EXPECT_TRUE(status.ok()) << status.message();
  return decoded;
}

template <typename CompressionT>
typename CompressionT::PointCloudPtr
roundTrip(CompressionT& encoder, const typename CompressionT::PointCloudConstPtr& cloud)
{
  using PointT = typename CompressionT::PointCloud::PointType;
  return roundTrip(encoder, io::OctreePointCloudIntensityCompression<PointT>(), cloud);
}

/** \brief The same with default settings except for the voxel edge. */
template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr
roundTrip(double resolution, const typename pcl::PointCloud<PointT>::ConstPtr& cloud)
{
  io::OctreePointCloudIntensityCompression<PointT> encoder(settingsWith(resolution));
  return roundTrip(encoder, cloud);
}

template <typename CompressionT>
std::string
encodeFrame(CompressionT& encoder,
            const typename CompressionT::PointCloudConstPtr& cloud)
{
  std::ostringstream stream;
  const io::CompressionStatus status = encoder.encodePointCloud(cloud, stream);
  EXPECT_TRUE(status.ok()) << status.message();
  return stream.str();
}

/** \brief Decodes bytes into a cloud that has other points. */
template <typename CompressionT>
io::CompressionStatus
decodeBytes(CompressionT& decoder,
            const std::string& bytes,
            typename CompressionT::PointCloudPtr& decoded)
{
  std::istringstream stream(bytes);
  decoded.reset(new typename CompressionT::PointCloud(31, 3));
  const io::CompressionStatus status = decoder.decodePointCloud(stream, decoded);
  EXPECT_EQ(decoder.getOutputCloud(), decoded);
  if (!status.ok()) {
    EXPECT_TRUE(decoded->empty());
    EXPECT_EQ(decoded->width * decoded->height, 0u);
    EXPECT_TRUE(decoded->is_dense);
  }
  return status;
}

} // namespace pcl_ext::test
