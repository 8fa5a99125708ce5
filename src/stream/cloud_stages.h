// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "bytes/exceptions.h"
#include "outliers/sensor_rest.h"
#include "rate/rate_control.h"
#include "stream/cloud_voxelizer.h"
#include "stream/frame_encoder.h"
#include "stream/frame_warnings.h"
#include "stream/point_contents.h"
#include "stream/scan_choice.h"
#include "voxelizing/scan_collector.h"

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The stages of CloudEncoder, and its members. */
class CloudStages {
public:
  using NoiseRemoval = CloudEncoder::NoiseRemoval;

  CloudStages(const EncoderSettings& settings,
              IntensityUnit unit,
              const std::optional<DepthLaw>& depth_law,
              const std::optional<NoiseRemoval>& noise_removal);

  void
  setResolution(double resolution, const std::optional<DepthLaw>& depth_law);

  /** \brief The stages of a cloud, from its points to the bytes of its frame; see
   * CloudEncoder::encode(). */
  CompressionStatus
  run(CloudSource& source, const CloudInfo& info, std::vector<std::uint8_t>& bytes);

  CompressionStatus
  voxelize(const PointView& points, const WorldPose& sensor_pose, VoxelFrame& frame);

  /** \brief The voxels of the last cloud, made of its points if it was coded as these. */
  const VoxelFrame&
  frame();

  /** \brief Removes all of the last cloud. */
  void
  clearFrame()
  {
    frame_.clearVoxels();
    is_scan_ = false;
  }

  /** \brief Columns and rows of the last cloud as it is decoded. */
  ImageSize
  decodedSize() const;

  /** \brief Calls a function of the stages. If it throws the next frame is an I-frame, as
   * a stage may have learned from a cloud that is not in the stream.
   * \return what it returns, OutOfMemory, or the status of invalid settings
   */
  template <typename FunctionT>
  CompressionStatus
  call(FunctionT function)
  {
    if (!settings_status_.ok())
      return settings_status_;
    const auto clean_up = [this] {
      clearFrame();
      encoder_.requestIFrame();
    };
    return callOrNoMemory([&] { return callOrCleanUp(function, clean_up); },
                          outOfMemoryStatus<CompressionStatus>);
  }

private:
  friend class CloudEncoder;

  void
  begin(const EncoderSettings& settings, const std::optional<DepthLaw>& depth_law);

  void
  takeSettings(const EncoderSettings& settings,
               const std::optional<DepthLaw>& depth_law);

  CompressionStatus
  leftOut() const;

  CompressionStatus
  encodeCloud(PointBatches& points,
              CloudSource& source,
              const CloudInfo& info,
              std::vector<std::uint8_t>& bytes);

  CompressionStatus
  encodeAsIFrame(PointBatches& points,
                 CloudSource& source,
                 const CloudInfo& info,
                 std::vector<std::uint8_t>& bytes);

  bool
  collectScan(PointBatches& points,
              const CloudInfo& info,
              bool is_i_frame_due,
              CompressionStatus& status);

  CompressionStatus
  encodeVoxels(PointBatches& points,
               CloudSource& source,
               const CloudInfo& info,
               std::vector<std::uint8_t>& bytes);

  CompressionStatus
  encodeScan(PointBatches& points,
             const CloudInfo& info,
             std::vector<std::uint8_t>& bytes);

  CompressionStatus
  voxelizeBatches(PointBatches& points,
                  const WorldPose& sensor_pose,
                  bool is_i_frame_due,
                  VoxelFrame& frame);

  void
  showBeyond(const OpenedCloud& cloud,
             PointBatches& points,
             const WorldPose& sensor_pose);

  CompressionStatus
  filterOverTime(const WorldPose& sensor_pose,
                 const std::optional<std::chrono::nanoseconds>& time);

  CompressionStatus
  describeFrame();

  LimitedCounts
  limitedCounts() const;

  IntensityUnit unit_;
  std::optional<NoiseRemoval> noise_removal_;
  EncoderSettings base_;     // of the first step of the rate control
  EncoderSettings settings_; // of the step in force
  std::optional<DepthLaw> depth_law_;
  CompressionStatus settings_status_;
  // These exist only if the settings are valid.
  std::optional<RateControl> rate_control_;
  std::optional<CloudVoxelizer> voxelizer_;
  std::optional<PointContents> contents_;
  std::optional<ScanCollector> scans_; // if settings allow scans
  std::optional<ScanChoice> scan_choice_;
  std::optional<TemporalVoxelFilter> temporal_filter_; // if it is on
  FrameMotion motion_;                                 // without a temporal filter
  FrameEncoder encoder_;
  // Of the last cloud:
  VoxelFrame frame_;
  scan::ScanFrame scan_;
  bool is_scan_ = false; // coded as such
  VoxelizationStatistics voxelization_;
  TemporalFilterStatus filtering_;
  FrameStatistics statistics_;
  bool is_step_new_ = false; // no frame of it is in the stream
};

} // namespace pcl_ext::PCL_EXT_ABI::io
