// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Asks the decoder's octree: is a place occupied, how sure are we, what is there at
// all? Then keeps an octree of its own, asks it what is new, and encodes it.
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include <iostream>
#include <sstream>

int
main()
{
  using Compression = pcl_ext::io::OctreePointCloudIntensityCompression<pcl::PointXYZI>;
  pcl_ext::io::IntensityCompressionSettings settings;
  settings.resolution = 0.1; // m
  settings.retain_octree = true;

  const pcl::PointCloud<pcl::PointXYZI>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZI>);
  cloud->emplace_back(0.22f, 0.31f, 0.47f, 10.0f);
  cloud->emplace_back(0.28f, 0.39f, 0.41f, 30.0f); // in the same voxel
  cloud->emplace_back(-3.0f, 5.0f, 1.0f, 200.0f);

  Compression encoder(settings);
  Compression decoder(settings);
  std::stringstream bytes;
  pcl::PointCloud<pcl::PointXYZI>::Ptr decoded(new pcl::PointCloud<pcl::PointXYZI>);
  if (!encoder.encodePointCloud(cloud, bytes).ok() ||
      !decoder.decodePointCloud(bytes, decoded).ok())
    return 1;

  pcl::PointXYZI place;
  place.x = 0.25f;
  place.y = 0.35f;
  place.z = 0.45f;
  std::cout << "occupied: " << decoder.isVoxelOccupiedAtPoint(place)
            << ", mean intensity: " << decoder.getVoxelIntensityAtPoint(place)
            << ", leaves: " << decoder.getLeafCount() << '\n';

  Compression::AlignedPointTVector centres;
  decoder.getOccupiedVoxelCenters(centres);
  for (const pcl::PointXYZI& centre : centres)
    std::cout << "occupied at " << centre.getVector3fMap().transpose() << '\n';

  // PCL's iterators work as on any octree.
  for (auto leaf = decoder.leaf_depth_begin(); leaf != decoder.leaf_depth_end(); ++leaf)
    std::cout << "intensity " << leaf.getLeafContainer().getIntensity() << '\n';

  const bool is_right = decoder.isVoxelOccupiedAtPoint(place) &&
                        decoder.getVoxelIntensityAtPoint(place) == 20.0f &&
                        centres.size() == 2;

  // As pcl::octree::OctreePointCloudChangeDetector, with decoded frames in place of
  // clouds.
  using pcl_ext::octree::IntensityLeaf;
  pcl_ext::octree::OctreePointCloudIntensity<pcl::PointXYZI,
                                             IntensityLeaf,
                                             pcl::octree::OctreeContainerEmpty,
                                             pcl::octree::Octree2BufBase<IntensityLeaf>>
      octree(settings.resolution);
  octree.defineBoundingBox(-6.4, -6.4, -6.4, 6.4, 6.4, 6.4);
  octree.addVoxels(decoder.voxelFrame());
  cloud->emplace_back(1.0f, 1.0f, 1.0f, 50.0f);
  if (!encoder.encodePointCloud(cloud, bytes).ok() ||
      !decoder.decodePointCloud(bytes, decoded).ok())
    return 1;
  octree.switchBuffers();
  octree.addVoxels(decoder.voxelFrame());
  octree.getNewVoxelCenters(centres);
  for (const pcl::PointXYZI& centre : centres)
    std::cout << "new at " << centre.getVector3fMap().transpose() << '\n';

  std::stringstream of_octree;
  const auto status = Compression(settings).encodeOctree(octree, of_octree);
  std::cout << octree.getLeafCount() << " leaves in " << of_octree.str().size()
            << " bytes\n";
  return is_right && centres.size() == 1 && status.ok() ? 0 : 1;
}
