// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// A project without PCL: points as an array -> voxels -> bytes, and back.
#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/version.h>

#include <cstdint>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

int
main()
{
  using namespace pcl_ext::io;
  EncoderSettings settings;
  settings.resolution = 0.1;
  std::vector<float> coordinates(3 * 1000);
  for (std::size_t i = 0; i < 1000; ++i)
    coordinates[3 * i] = 0.01f * static_cast<float>(i);
  PointView points;
  points.coordinates = coordinates.data();
  points.coordinate_stride = 3 * sizeof(float);
  points.count = 1000;

  CloudEncoder encoder(settings, pcl_ext::IntensityUnit::Points);
  std::vector<std::uint8_t> bytes;
  const CompressionStatus encoded = encoder.encode(points, {}, bytes);
  const VoxelFrame& frame = encoder.frame();
  DecoderLimits limits;
  limits.budget = std::make_shared<MemoryBudget>();
  FrameDecoder decoder(limits);
  VoxelFrame decoded;
  const CompressionStatus status = decoder.decode(bytes.data(), bytes.size(), decoded);
  std::cout << decoded.size() << " voxels " << encoded.message() << status.message()
            << '\n';
  const bool is_same =
      decoded.keys == frame.keys && decoded.intensities == frame.intensities;
  pcl_ext::VoxelOutlierRemoval removal;
  if (!removal.filter(decoded).ok())
    return 1;
  if (std::string(pcl_ext::version()) != PCL_EXT_VERSION_TEXT || PCL_EXT_VERSION < 200)
    return 1;
  return is_same && frame.size() == 100 ? 0 : 1;
}
