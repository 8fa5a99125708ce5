// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * The paper's sections 3.1 and 3.2: the streams of the simulated robot cell one by one.
 */
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "depth_images.h"
#include "experiments/tables.h"
#include "measuring/results.h"
#include "measuring/samples.h"
#include "measuring/workload.h"
#include "simulator/robot_cell.h"

#include <algorithm>
#include <iostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace experiments {

namespace {

using cell::RobotCell;
using measuring::InputStream;
using measuring::Results;
using measuring::Samples;
using measuring::Subject;
using measuring::timeOf;

/** \brief Frames of each of the 20 resolutions. */
constexpr std::size_t most_frames_of_sweep = 100;

/** \brief A way to code a stream, and the name that its results get. */
struct StreamCoder {
  Subject subject;
  nodes::SensorNodeSettings settings;
};

/** \brief One coder of a stream, and its results. */
class CoderRun {
public:
  CoderRun(const StreamCoder& coder, double frame_rate)
  : subject_(coder.subject), node_(coder.settings), frame_rate_(frame_rate)
  {}

  void
  code(const pcl::PCLPointCloud2& cloud, const WorldPose& pose)
  {
    nodes::SensorNodeStatus status;
    encode_ms_.add(timeOf([&] { status = node_.encode(cloud, pose, bytes_); }));
    if (!status.hasFrame())
      throw std::runtime_error(name() + ": " + status.message());
    io::CompressionStatus decoded;
    decode_ms_.add(timeOf(
        [&] { decoded = decoder_.decode(bytes_.data(), bytes_.size(), voxels_); }));
    const io::FrameStatistics frame = node_.statistics().frame;
    if (!decoded.ok() || voxels_.size() != frame.coding.voxels)
      throw std::runtime_error(name() +
                               ": the decoded frame differs: " + decoded.message());
    voxel_count_.add(static_cast<double>(frame.coding.voxels));
    bytes_per_voxel_.add(frame.bytesPerVoxel());
    const auto size = static_cast<double>(bytes_.size());
    const auto cropped_points = static_cast<double>(frame.voxelization.points_used);
    sizes_.add(size);
    ratio_.add(16.0 * cropped_points / size);
    megabits_per_second_.add(8e-6 * size * frame_rate_);
  }

  void
  write(measuring::Results& results) const
  {
    results.add(subject_, "voxels", voxel_count_);
    results.add(subject_, "bytes_per_voxel", bytes_per_voxel_);
    results.add(subject_, "bytes", sizes_);
    results.add(subject_, "ratio", ratio_);
    results.add(subject_, "megabits_per_second", megabits_per_second_);
    results.add(subject_, "encode_ms", encode_ms_);
    results.add(subject_, "decode_ms", decode_ms_);
  }

private:
  std::string
  name() const
  {
    return subject_.sensor + ", " + subject_.coder;
  }

  measuring::Subject subject_;
  nodes::SensorNode node_;
  double frame_rate_; ///< Hz
  io::FrameDecoder decoder_;
  std::vector<std::uint8_t> bytes_;
  io::VoxelFrame voxels_;

  Samples voxel_count_;
  Samples bytes_per_voxel_;
  Samples sizes_;
  Samples ratio_; ///< of 16 bytes for each cropped point to the frame's
  Samples megabits_per_second_;
  Samples encode_ms_; ///< cloud to bytes, preprocessing included; processor time
  Samples decode_ms_; ///< bytes to voxels
};

/** \brief Sends every cloud of a stream, which is read once, through a SensorNode and a
 * decoder for each coder.
 * \throws std::runtime_error if a frame cannot be coded, or its decoded voxels differ
 * in number
 */
void
measureCoders(const InputStream& stream,
              double frame_rate,
              const std::vector<StreamCoder>& coders,
              Results& results)
{
  std::vector<CoderRun> runs;
  for (const StreamCoder& coder : coders)
    runs.emplace_back(coder, frame_rate);
  const WorldPose pose(stream.clouds->sensorPose());
  pcl::PCLPointCloud2 cloud;
  for (std::size_t i = 0; i < stream.clouds->size(); ++i) {
    stream.clouds->read(i, cloud);
    for (CoderRun& run : runs)
      run.code(cloud, pose);
  }
  for (const CoderRun& run : runs)
    run.write(results);
}

/** \brief Moves and crops every cloud of a stream. cloud_points are all, also without a
 * return. */
void
measureCropping(const InputStream& stream, const Subject& subject, Results& results)
{
  const auto preprocess =
      measuring::makePreprocessing<pcl::PCLPointCloud2>(IntensityLaw::Count,
                                                        subject.resolution,
                                                        std::nullopt,
                                                        stream.clouds->sensorPose(),
                                                        stream.crop_box);
  pcl::PCLPointCloud2 cloud;
  measuring::IntensityCloud cropped;
  Samples cloud_points, points, cropped_points, cropping_ratio, kept_percent,
      preprocess_ms;
  for (std::size_t i = 0; i < stream.clouds->size(); ++i) {
    stream.clouds->read(i, cloud);
    PreprocessingStatistics statistics;
    preprocess_ms.add(timeOf([&] { statistics = preprocess(cloud, cropped); }));
    const double all = static_cast<double>(statistics.points);
    const double finite = all - static_cast<double>(statistics.points_not_finite);
    const double inside = static_cast<double>(cropped.size());
    cloud_points.add(all);
    points.add(finite);
    cropped_points.add(inside);
    cropping_ratio.add(all / inside);
    kept_percent.add(100.0 * inside / finite);
  }
  results.add(subject, "cloud_points", cloud_points);
  results.add(subject, "points", points);
  results.add(subject, "cropped_points", cropped_points);
  results.add(subject, "cropping_ratio", cropping_ratio);
  results.add(subject, "kept_percent", kept_percent);
  results.add(subject, "preprocess_ms", preprocess_ms);
}

void
printProgress(const std::string& what)
{
  std::cerr << "streams: " << what << '\n';
}

/** \brief Adds a coder of each variant.
 * \param[in] subject of the results, less the coder
 */
void
addCoders(const Subject& subject,
          const InputStream& stream,
          IntensityLaw law,
          std::vector<StreamCoder>& coders)
{
  measuring::Workload workload;
  workload.resolution = subject.resolution;
  for (const measuring::Variant& variant : measuring::libraryVariants()) {
    StreamCoder coder{subject,
                      measuring::sensorNodeSettings(stream, workload, variant)};
    coder.subject.coder = variant.name;
    coder.settings.law = law;
    coder.settings.sensor = runtimeSensor(KinectV2());
    coders.push_back(coder);
  }
}

/** \brief Cropping, and compression at 4 and 2 cm, of one sensor. */
void
measureSensor(unsigned int number, const Options& options, Results& results)
{
  const std::string sensor = std::to_string(number);
  printProgress("sensor " + sensor);
  const bool is_lidar = number == RobotCell::lidar;
  const InputStream stream = is_lidar
                                 ? measuring::openLidarStream(options.frames)
                                 : measuring::openCellStream(number, options.frames);
  measureCropping(stream, {"cropping", sensor, "SensorPreprocessor", 0.04}, results);
  std::vector<StreamCoder> coders;
  for (const double resolution : {0.04, 0.02})
    addCoders({"compression", sensor, "", resolution},
              stream,
              is_lidar ? IntensityLaw::Native : IntensityLaw::Count,
              coders);
  measureCoders(stream,
                is_lidar ? RobotCell::lidar_rate : RobotCell::frame_rate,
                coders,
                results);
}

/** \brief Sensor 1 with the two laws that depend on depth. */
void
measureLaws(const Options& options, Results& results)
{
  printProgress("laws of intensity");
  const InputStream stream = measuring::openCellStream(1, options.frames);
  std::vector<StreamCoder> coders;
  for (const IntensityLaw law : {IntensityLaw::Quadratic, IntensityLaw::Linear})
    addCoders({nameOf(law), "1", "", 0.04}, stream, law, coders);
  measureCoders(stream, RobotCell::frame_rate, coders, results);
}

/** \brief Sensor 1 at 1 to 20 cm. */
void
measureResolutions(const Options& options, Results& results)
{
  printProgress("resolutions");
  const InputStream stream =
      measuring::openCellStream(1, std::min(options.frames, most_frames_of_sweep));
  std::vector<StreamCoder> coders;
  for (int centimetres = 1; centimetres <= 20; ++centimetres)
    addCoders({"resolution", "1", "", centimetres / 100.0},
              stream,
              IntensityLaw::Count,
              coders);
  measureCoders(stream, RobotCell::frame_rate, coders, results);
}

} // namespace

void
measureStreams(const Options& options, std::ostream& output)
{
  Results results(output);
  for (unsigned int number = 1; number <= RobotCell::lidar; ++number)
    measureSensor(number, options, results);
  measureLaws(options, results);
  measureResolutions(options, results);
#ifdef PCL_EXT_EXPERIMENTS_IMAGES
  printProgress("depth images");
  paper::measureDepthImages(*measuring::openCellStream(1, options.frames).clouds,
                            results);
#endif
}

} // namespace experiments
} // namespace pcl_ext
