// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * Draco's coders. KD-tree over this library's voxels: positions as whole numbers, the
 * quantised intensity as a further attribute, both without loss. KD-tree and sequential
 * over all points as whole numbers.
 */
#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/impl/point_intensity.h>

#include "coders/stream_coder.h"
#include "coders/whole_number_coder.h"
#include "meters/decoded_checks.h"

#include <pcl/common/io.h>

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/core/draco_version.h>
#include <draco/point_cloud/point_cloud_builder.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

namespace {

std::string
dracoName()
{
  return std::string("Draco ") + draco::kDracoVersion;
}

using Intensities = std::vector<std::uint8_t>;

/** \brief Encodes points, and their intensities where there are any.
 * \param[in] speed 0 is smallest, 10 fastest
 */
void
encodeWithDraco(const WholePositions& positions,
                const Intensities& intensities,
                draco::PointCloudEncodingMethod method,
                int speed,
                draco::EncoderBuffer& bytes)
{
  draco::PointCloudBuilder builder;
  builder.Start(static_cast<std::uint32_t>(positions.size()));
  const int position_id =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_UINT32);
  builder.SetAttributeValuesForAllPoints(position_id, positions.data(), 0);
  if (!intensities.empty())
    builder.SetAttributeValuesForAllPoints(
        builder.AddAttribute(draco::GeometryAttribute::GENERIC, 1, draco::DT_UINT8),
        intensities.data(),
        0);
  const auto cloud = builder.Finalize(/* deduplicate_points */ false);
  draco::ExpertEncoder encoder(*cloud);
  encoder.SetEncodingMethod(method);
  encoder.SetSpeedOptions(speed, speed);
  bytes.Clear();
  if (const draco::Status status = encoder.EncodeToBuffer(&bytes); !status.ok())
    throw std::runtime_error("Draco: " + status.error_msg_string());
}

/** \brief Decodes points; intensities where the bytes have them. */
void
decodeWithDraco(const draco::EncoderBuffer& bytes,
                WholePositions& positions,
                Intensities& intensities)
{
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto result = decoder.DecodePointCloudFromBuffer(&buffer);
  if (!result.ok())
    throw std::runtime_error("Draco: " + result.status().error_msg_string());
  const draco::PointCloud& cloud = *result.value();
  const draco::PointAttribute* decoded_positions =
      cloud.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  const draco::PointAttribute* decoded_intensities =
      cloud.GetNamedAttribute(draco::GeometryAttribute::GENERIC);
  if (decoded_positions == nullptr)
    throw std::runtime_error("Draco decoded a cloud without positions");
  positions.resize(cloud.num_points());
  intensities.resize(decoded_intensities == nullptr ? 0 : cloud.num_points());
  for (std::uint32_t i = 0; i < cloud.num_points(); ++i) {
    decoded_positions->GetMappedValue(draco::PointIndex(i), positions[i].data());
    if (decoded_intensities != nullptr)
      decoded_intensities->GetMappedValue(draco::PointIndex(i), &intensities[i]);
  }
}

class DracoCoder : public StreamCoder {
public:
  /** \param[in] speed 0 is smallest, 10 fastest */
  DracoCoder(const Workload& workload, std::string name, int speed)
  : StreamCoder(std::move(name), Content::VoxelsWithIntensity)
  , encoder_(compressionSettings(workload, libraryVariants().front()),
             IntensityUnit::Native)
  , speed_(speed)
  , intensity_tolerance_(workload.law == IntensityLaw::Count ? 0.0 : 0.501)
  {}

  void
  encode(const InputFrame& frame) override
  {
    voxelize(*frame.points);
    const std::size_t count = voxels_.size();
    voxel_positions_.resize(count);
    intensities_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const io::VoxelPosition position = io::voxelPosition(voxels_.keys[i]);
      voxel_positions_[i] = {position.x, position.y, position.z};
      intensities_[i] = static_cast<std::uint8_t>(voxels_.intensities[i]);
    }
    encodeWithDraco(voxel_positions_,
                    intensities_,
                    draco::POINT_CLOUD_KD_TREE_ENCODING,
                    speed_,
                    bytes_);
    frame_bytes_ = bytes_.size();
  }

  void
  decode() override
  {
    decodeWithDraco(bytes_, voxel_positions_, intensities_);
    if (intensities_.size() != voxel_positions_.size())
      throw std::runtime_error("Draco decoded a cloud without intensities");
    decoded_->resize(voxel_positions_.size());
    for (std::size_t i = 0; i < voxel_positions_.size(); ++i) {
      pcl::PointXYZI& point = (*decoded_)[i];
      point.x = static_cast<float>(voxels_.grid.centre(0, voxel_positions_[i][0]));
      point.y = static_cast<float>(voxels_.grid.centre(1, voxel_positions_[i][1]));
      point.z = static_cast<float>(voxels_.grid.centre(2, voxel_positions_[i][2]));
      point.intensity = voxels_.intensity_scale.value(intensities_[i]);
    }
  }

  void
  check(const InputFrame& frame) override
  {
    const Lattice lattice{voxels_.grid.origin, voxels_.grid.resolution};
    pcl::copyPointCloud(*decoded_, *positions_);
    checkVoxels(*frame.positions, *positions_, lattice, /* face_tolerance */ 0.0);
    checkIntensities(
        *frame.points, *decoded_, lattice, /* top */ 255.0, intensity_tolerance_);
  }

private:
  void
  voxelize(const IntensityCloud& points)
  {
    throwUnlessOk(encoder_.voxelize(
        pointViewWithIntensities(points), WorldPose::Identity(), voxels_));
  }

  io::CloudEncoder encoder_;
  int speed_;
  double intensity_tolerance_;
  io::VoxelFrame voxels_;
  WholePositions voxel_positions_;
  Intensities intensities_;
  draco::EncoderBuffer bytes_;
  IntensityCloud::Ptr decoded_{new IntensityCloud};
};

/** \brief All points, as whole numbers. */
class DracoPointsCoder : public WholeNumberCoder {
public:
  DracoPointsCoder(const Workload& workload,
                   const std::string& name,
                   draco::PointCloudEncodingMethod method)
  : WholeNumberCoder(dracoName() + ", " + name, workload.resolution), method_(method)
  {}

protected:
  void
  encodePositions(const WholePositions& positions) override
  {
    encodeWithDraco(positions, {}, method_, /* speed */ 0, bytes_);
    frame_bytes_ = bytes_.size();
  }

  void
  decodePositions(WholePositions& positions) override
  {
    Intensities none;
    decodeWithDraco(bytes_, positions, none);
  }

private:
  draco::PointCloudEncodingMethod method_;
  draco::EncoderBuffer bytes_;
};

} // namespace

void
addDracoCoders(const Workload& workload, StreamCoders& coders)
{
  coders.push_back(
      std::make_unique<DracoCoder>(workload, dracoName() + ", smallest", 0));
  coders.push_back(
      std::make_unique<DracoCoder>(workload, dracoName() + ", fastest", 10));
}

void
addDracoPointsCoders(const Workload& workload, StreamCoders& coders)
{
  coders.push_back(std::make_unique<DracoPointsCoder>(
      workload, "KD-tree", draco::POINT_CLOUD_KD_TREE_ENCODING));
  coders.push_back(std::make_unique<DracoPointsCoder>(
      workload, "sequential", draco::POINT_CLOUD_SEQUENTIAL_ENCODING));
}

} // namespace measuring
} // namespace pcl_ext
