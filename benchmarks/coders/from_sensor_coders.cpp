// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * Ways from the sensor's organised cloud to bytes.
 */
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "coders/stream_coder.h"
#include "meters/decoded_checks.h"

#include <pcl/common/io.h>
#include <pcl/common/transforms.h>
#include <pcl/conversions.h>
#include <pcl/filters/crop_box.h>
#include <pcl/PCLPointCloud2.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief Moves and crops the cloud, and has another coder encode it. */
class FromSensorCoder : public StreamCoder {
public:
  explicit FromSensorCoder(std::unique_ptr<StreamCoder> coder)
  : StreamCoder(coder->name(), coder->content()), coder_(std::move(coder))
  {}

  void
  prepare(const InputFrame& frame) override
  {
    *input_.raw = *frame.raw;
  }

  void
  encode(const InputFrame& /* frame */) override
  {
    moveAndCrop(input_);
    coder_->encode(input_);
    frame_bytes_ = coder_->frameBytes();
  }

  void
  decode() override
  {}

  void
  check(const InputFrame& frame) override
  {
    if (input_.positions->empty())
      pcl::copyPointCloud(*input_.points, *input_.positions);
    // A point on a face of the box may fall on either side when it is moved.
    const double kept = static_cast<double>(input_.positions->size());
    const double expected = static_cast<double>(frame.points->size());
    if (std::abs(kept - expected) > 0.001 * expected)
      throw std::runtime_error("it keeps " + std::to_string(kept) + " points of " +
                               std::to_string(expected));
    coder_->decode();
    coder_->check(input_);
    *positions_ = *coder_->decodedPositions();
  }

protected:
  /** \brief Makes what the coder encodes of the raw cloud. */
  virtual void
  moveAndCrop(InputFrame& input) = 0;

private:
  std::unique_ptr<StreamCoder> coder_;
  InputFrame input_;
};

class FromSensorLibraryCoder : public FromSensorCoder {
public:
  FromSensorLibraryCoder(const InputStream& stream,
                         const Workload& workload,
                         std::unique_ptr<StreamCoder> coder)
  : FromSensorCoder(std::move(coder)), preprocess_(makePreprocessing(workload, stream))
  {}

protected:
  void
  moveAndCrop(InputFrame& input) override
  {
    preprocess_(*input.raw, *input.points);
    input.positions->clear(); // only the check needs them
  }

private:
  Preprocessing<PositionCloud> preprocess_;
};

class FromSensorPclCoder : public FromSensorCoder {
public:
  FromSensorPclCoder(const InputStream& stream, std::unique_ptr<StreamCoder> coder)
  : FromSensorCoder(std::move(coder))
  , sensor_pose_(stream.clouds->sensorPose().cast<float>().matrix())
  {
    Eigen::Vector4f min = Eigen::Vector4f::Ones();
    Eigen::Vector4f max = Eigen::Vector4f::Ones();
    min.head<3>() = Eigen::Vector3d(stream.crop_box->min.data()).cast<float>();
    max.head<3>() = Eigen::Vector3d(stream.crop_box->max.data()).cast<float>();
    crop_box_.setMin(min);
    crop_box_.setMax(max);
  }

protected:
  void
  moveAndCrop(InputFrame& input) override
  {
    pcl::transformPointCloud(*input.raw, *moved_, sensor_pose_);
    crop_box_.setInputCloud(moved_);
    crop_box_.filter(*input.positions);
  }

private:
  Eigen::Matrix4f sensor_pose_;
  pcl::CropBox<pcl::PointXYZ> crop_box_;
  PositionCloud::Ptr moved_{new PositionCloud};
};

/** \brief SensorNode, from the message to bytes in one pass. */
class SensorNodeCoder : public StreamCoder {
public:
  SensorNodeCoder(const InputStream& stream,
                  const Workload& workload,
                  const Variant& variant)
  : StreamCoder(std::string("pcl_ext, SensorNode, ") + variant.name,
                Content::VoxelsWithIntensity)
  , sensor_pose_(stream.clouds->sensorPose())
  , node_(settingsOf(stream, workload, variant))
  {
    decoder_.setDecodesVoxels(false);
  }

  void
  prepare(const InputFrame& frame) override
  {
    pcl::toPCLPointCloud2(*frame.raw, message_);
  }

  void
  encode(const InputFrame& /* frame */) override
  {
    const nodes::SensorNodeStatus status = node_.encode(message_, sensor_pose_, bytes_);
    if (!status.ok())
      throw std::runtime_error(status.message());
    frame_bytes_ = bytes_.size();
  }

  void
  decode() override
  {}

  void
  check(const InputFrame& frame) override
  {
    throwUnlessOk(decoder_.decode(bytes_.data(), bytes_.size(), voxels_));
    io::detail::fillCloud(voxels_, *positions_);
    checkVoxels(*frame.positions,
                *positions_,
                {voxels_.grid.origin, voxels_.grid.resolution},
                /* face_tolerance */ 0.0);
  }

private:
  static nodes::SensorNodeSettings
  settingsOf(const InputStream& stream,
             const Workload& workload,
             const Variant& variant)
  {
    nodes::SensorNodeSettings settings;
    settings.compression = compressionSettings(workload, variant);
    settings.law = workload.law;
    settings.crop_box = stream.crop_box;
    return settings;
  }

  WorldPose sensor_pose_;
  nodes::SensorNode node_;
  io::FrameDecoder decoder_;
  pcl::PCLPointCloud2 message_;
  std::vector<std::uint8_t> bytes_;
  io::VoxelFrame voxels_;
};

} // namespace

StreamCoders
makeFromSensorCoders(const InputStream& stream, const Workload& workload)
{
  StreamCoders library;
  addLibraryCoders(workload, library);
  StreamCoders pcl;
  addPclVoxelGridCoder(workload, pcl);
  StreamCoders coders;
  for (auto& coder : library)
    coders.push_back(
        std::make_unique<FromSensorLibraryCoder>(stream, workload, std::move(coder)));
  coders.push_back(
      std::make_unique<SensorNodeCoder>(stream, workload, libraryVariants().front()));
  coders.push_back(
      std::make_unique<FromSensorPclCoder>(stream, std::move(pcl.front())));
  return coders;
}

} // namespace measuring
} // namespace pcl_ext
