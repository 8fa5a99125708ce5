// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/nodes/impl/cloud_receiver.h>

#include "bytes/exceptions.h"
#include "nodes/latency.h"
#include "nodes/received_stream.h"

#include <mutex>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

class CloudReceiver::Implementation {
public:
  explicit Implementation(const io::DecoderLimits& limits)
  : stream_("", CentralNode::lowest_intensity, limits)
  {
    stream_.leaveVoxelsOut();
  }

  void
  setNoise(const NoiseSettings& noise)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    min_intensity_ = noise.min_intensity;
    stream_.setMinIntensity(noise.lowestIntensity());
    stream_.setOutlierRemoval(noise.outlier_removal);
    stream_.setPacked(noise.is_packed);
  }

  ReceiverStatus
  receive(std::vector<std::uint8_t> bytes,
          std::optional<Time> stamp,
          io::VoxelFrame& voxels)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    last_arrival_ = steadyTime();
    ReceiverStatus status = callOrElse(
        [&] { return receiveOrThrow(std::move(bytes), stamp, voxels); },
        [] {
          return ReceiverStatus(outOfMemoryStatus<io::CompressionStatus>(), false);
        },
        [](const std::string& reason) {
          return ReceiverStatus(io::CompressionCode::InputFailed, reason);
        });
    if (!status.ok())
      voxels = io::VoxelFrame();
    return status;
  }

  void
  countLeftOut()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    last_arrival_ = steadyTime();
    ++left_out_;
  }

  ReceiverHealth
  health() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return {stream_.health(systemTime()), left_out_, min_intensity_, last_arrival_};
  }

private:
  ReceiverStatus
  receiveOrThrow(std::vector<std::uint8_t> bytes,
                 std::optional<Time> stamp,
                 io::VoxelFrame& voxels)
  {
    const auto admission = stream_.admit(std::move(bytes), stamp, 1, [] {});
    if (admission != ReceivedStream::Admission::Waits)
      return {outOfMemoryStatus<io::CompressionStatus>(), false};
    ReceiverStatus status;
    stream_.decodeNext(systemTime, [&](const ReceivedFrame& frame) {
      status = {frame.status, frame.wants_i_frame};
      voxels = frame.voxels();
    });
    stream_.endTurn();
    return status;
  }

  mutable std::mutex mutex_; // guards everything below
  ReceivedStream stream_;
  float min_intensity_ = 0.0f;
  std::size_t left_out_ = 0;
  std::optional<Time> last_arrival_;
};

CloudReceiver::CloudReceiver(const io::DecoderLimits& limits)
: implementation_(std::make_unique<Implementation>(limits))
{}

CloudReceiver::~CloudReceiver() = default;

void
CloudReceiver::setNoise(const NoiseSettings& noise)
{
  implementation_->setNoise(noise);
}

ReceiverStatus
CloudReceiver::receive(std::vector<std::uint8_t> bytes,
                       std::optional<Time> stamp,
                       io::VoxelFrame& voxels)
{
  return implementation_->receive(std::move(bytes), stamp, voxels);
}

void
CloudReceiver::countLeftOut()
{
  implementation_->countLeftOut();
}

ReceiverHealth
CloudReceiver::health() const
{
  return implementation_->health();
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
