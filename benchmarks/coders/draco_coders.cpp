/** \file
 * Draco's KD-tree coder over this library's voxels: positions as whole numbers, the
 * quantised intensity as a further attribute, both without loss.
 */
#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/point_intensity.h>

#include "coders/stream_coder.h"
#include "meters/decoded_checks.h"

#include <pcl/common/io.h>

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/core/draco_version.h>
#include <draco/point_cloud/point_cloud_builder.h>

#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

namespace {

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
    const auto count = static_cast<std::uint32_t>(voxels_.size());
    positions_.resize(count);
    intensities_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const io::VoxelPosition position = io::voxelPosition(voxels_.keys[i]);
      positions_[i] = {position.x, position.y, position.z};
      intensities_[i] = static_cast<std::uint8_t>(voxels_.intensities[i]);
    }
    draco::PointCloudBuilder builder;
    builder.Start(count);
    const int position_id =
        builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_UINT32);
    const int intensity_id =
        builder.AddAttribute(draco::GeometryAttribute::GENERIC, 1, draco::DT_UINT8);
    builder.SetAttributeValuesForAllPoints(position_id, positions_.data(), 0);
    builder.SetAttributeValuesForAllPoints(intensity_id, intensities_.data(), 0);
    const auto cloud = builder.Finalize(/* deduplicate_points */ false);
    draco::ExpertEncoder encoder(*cloud);
    encoder.SetEncodingMethod(draco::POINT_CLOUD_KD_TREE_ENCODING);
    encoder.SetSpeedOptions(speed_, speed_);
    bytes_.Clear();
    if (const draco::Status status = encoder.EncodeToBuffer(&bytes_); !status.ok())
      throw std::runtime_error("Draco: " + status.error_msg_string());
  }

  std::size_t
  frameBytes() const override
  {
    return bytes_.size();
  }

  void
  decode() override
  {
    draco::DecoderBuffer buffer;
    buffer.Init(bytes_.data(), bytes_.size());
    draco::Decoder decoder;
    auto result = decoder.DecodePointCloudFromBuffer(&buffer);
    if (!result.ok())
      throw std::runtime_error("Draco: " + result.status().error_msg_string());
    const draco::PointCloud& cloud = *result.value();
    const draco::PointAttribute* positions =
        cloud.GetNamedAttribute(draco::GeometryAttribute::POSITION);
    const draco::PointAttribute* intensities =
        cloud.GetNamedAttribute(draco::GeometryAttribute::GENERIC);
    if (positions == nullptr || intensities == nullptr)
      throw std::runtime_error("Draco decoded a cloud without its attributes");
    decoded_->resize(cloud.num_points());
    for (std::uint32_t i = 0; i < cloud.num_points(); ++i) {
      std::array<std::uint32_t, 3> position;
      std::uint8_t intensity = 0;
      positions->GetMappedValue(draco::PointIndex(i), position.data());
      intensities->GetMappedValue(draco::PointIndex(i), &intensity);
      pcl::PointXYZI& point = (*decoded_)[i];
      point.x = static_cast<float>(voxels_.grid.centre(0, position[0]));
      point.y = static_cast<float>(voxels_.grid.centre(1, position[1]));
      point.z = static_cast<float>(voxels_.grid.centre(2, position[2]));
      point.intensity = voxels_.intensity_scale.value(intensity);
    }
  }

  void
  check(const InputFrame& frame) override
  {
    const Lattice lattice{voxels_.grid.origin, voxels_.grid.resolution};
    pcl::copyPointCloud(*decoded_, *decoded_positions_);
    checkVoxels(
        *frame.positions, *decoded_positions_, lattice, /* face_tolerance */ 0.0);
    checkIntensities(
        *frame.points, *decoded_, lattice, /* top */ 255.0, intensity_tolerance_);
  }

  PositionCloud::ConstPtr
  decodedPositions() const override
  {
    return decoded_positions_;
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
  std::vector<std::array<std::uint32_t, 3>> positions_;
  std::vector<std::uint8_t> intensities_;
  draco::EncoderBuffer bytes_;
  IntensityCloud::Ptr decoded_{new IntensityCloud};
  PositionCloud::Ptr decoded_positions_{new PositionCloud};
};

} // namespace

void
addDracoCoders(const Workload& workload, StreamCoders& coders)
{
  const std::string draco = std::string("Draco ") + draco::kDracoVersion;
  coders.push_back(std::make_unique<DracoCoder>(workload, draco + ", smallest", 0));
  coders.push_back(std::make_unique<DracoCoder>(workload, draco + ", fastest", 10));
}

} // namespace measuring
} // namespace pcl_ext
