// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// The program of PCL's tutorial "Point Cloud Compression", switched to pcl_ext: the
// include, the class and what the callback prints are all that changed, apart from the
// camera, whose place a waving surface takes here, so that the example runs anywhere.
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <cmath>
#include <iostream>
#include <sstream>

class SimpleCloudStream {
public:
  SimpleCloudStream()
  {
    const bool show_statistics = true;
    const pcl::io::compression_Profiles_e profile =
        pcl::io::MED_RES_ONLINE_COMPRESSION_WITH_COLOR;
    // Before: new pcl::io::OctreePointCloudCompression<pcl::PointXYZRGBA>(...)
    encoder_.reset(new Compression(profile, show_statistics));
    decoder_.reset(new Compression());
  }

  bool
  cloudCallback(const pcl::PointCloud<pcl::PointXYZRGBA>::ConstPtr& cloud)
  {
    std::stringstream compressed_data;
    const pcl::PointCloud<pcl::PointXYZRGBA>::Ptr cloud_out(
        new pcl::PointCloud<pcl::PointXYZRGBA>);
    pcl::PointCloud<pcl::PointXYZRGBA>::Ptr decoded = cloud_out;

    encoder_->encodePointCloud(cloud, compressed_data);
    // PCL's class returns nothing here, this one a status.
    const auto status = decoder_->decodePointCloud(compressed_data, decoded);
    std::cout << cloud->size() << " points were decoded as " << decoded->size()
              << " in " << encoder_->statistics().coding.bytes << " bytes "
              << status.message() << '\n';
    return status.ok() && !decoded->empty();
  }

private:
  using Compression =
      pcl_ext::io::OctreePointCloudIntensityCompression<pcl::PointXYZRGBA>;

  Compression::Ptr encoder_;
  Compression::Ptr decoder_;
};

pcl::PointCloud<pcl::PointXYZRGBA>::Ptr
wavingSurface(int frame)
{
  const pcl::PointCloud<pcl::PointXYZRGBA>::Ptr cloud(
      new pcl::PointCloud<pcl::PointXYZRGBA>);
  for (float x = -1.0f; x < 1.0f; x += 0.01f)
    for (float y = -1.0f; y < 1.0f; y += 0.01f) {
      pcl::PointXYZRGBA point;
      point.x = x;
      point.y = y;
      point.z = 2.0f + 0.1f * std::sin(3.0f * x + 0.1f * static_cast<float>(frame));
      cloud->push_back(point);
    }
  return cloud;
}

int
main()
{
  SimpleCloudStream stream;
  for (int frame = 0; frame < 5; ++frame)
    if (!stream.cloudCallback(wavingSurface(frame)))
      return 1;
  return 0;
}
