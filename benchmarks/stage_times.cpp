#include "stage_times.h"

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/nodes/sensor_node.h>
#include <pcl_ext/point_intensity.h>

#include "frame_buffer.h"
#include "pcl_compression.h"
#include "take_turns.h"

#include <pcl/common/transforms.h>
#include <pcl/conversions.h>
#include <pcl/filters/crop_box.h>
#include <pcl/PCLPointCloud2.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <istream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

namespace {

constexpr const char* sensor_node_name = "pcl_ext, SensorNode";

/** \brief Times of one frame; sent from the coder's process to the parent's. */
struct FrameTimes {
  double preprocess_ms = 0.0;
  double voxelize_ms = 0.0;
  double code_ms = 0.0;
  double decode_ms = 0.0;
  double class_encode_ms = 0.0;
  double class_decode_ms = 0.0;
  std::size_t bytes = 0;
};

/** \brief A coder with the steps before it. */
class TimedCoder {
public:
  virtual ~TimedCoder() = default;

  virtual FrameTimes
  run(const InputFrame& frame) = 0;
};

class TimedVariant : public TimedCoder {
public:
  /** \param[in] times_stages false: only preprocessing and the class's encoding run, so
   * that no other work comes between two frames
   */
  TimedVariant(const InputStream& stream,
               const Workload& workload,
               const Variant& variant,
               bool times_stages)
  : times_stages_(times_stages)
  , preprocess_(makePreprocessing(workload, stream))
  , sensor_pose_(stream.clouds->sensorPose())
  , cloud_encoder_(compressionSettings(workload, variant),
                   IntensityUnit::Native,
                   compressionSettings(workload, variant).depth_law)
  , encoder_(compressionSettings(workload, variant))
  , decoder_(compressionSettings(workload, variant))
  {}

  FrameTimes
  run(const InputFrame& frame) override
  {
    // The cloud has just been written, as by a driver.
    raw_ = *frame.raw;
    FrameTimes times;
    times.preprocess_ms = timeOf([&] { preprocess_(raw_, *points_); });
    if (times_stages_)
      runStages(times);
    buffer_.restart();
    stream_.clear();
    times.class_encode_ms =
        timeOf([&] { throwUnlessOk(encoder_.encodePointCloud(points_, stream_)); });
    times.bytes = buffer_.size();
    if (times_stages_) {
      times.class_decode_ms =
          timeOf([&] { throwUnlessOk(decoder_.decodePointCloud(stream_, decoded_)); });
      if (!isSame(voxels_, decoded_voxels_) || !isSame(voxels_, decoder_.voxelFrame()))
        throw std::runtime_error("the decoded frame differs from the encoded one");
    }
    return times;
  }

private:
  void
  runStages(FrameTimes& times)
  {
    const io::PointView view = pointViewWithIntensities(*points_);
    times.voxelize_ms = timeOf(
        [&] { throwUnlessOk(cloud_encoder_.voxelize(view, sensor_pose_, voxels_)); });
    times.code_ms = timeOf(
        [&] { throwUnlessOk(cloud_encoder_.encode(voxels_, std::nullopt, bytes_)); });
    times.decode_ms = timeOf([&] {
      throwUnlessOk(
          frame_decoder_.decode(bytes_.data(), bytes_.size(), decoded_voxels_));
    });
  }

  static bool
  isSame(const io::VoxelFrame& a, const io::VoxelFrame& b)
  {
    return a.keys == b.keys && a.intensities == b.intensities;
  }

  bool times_stages_;
  Preprocessing<PositionCloud> preprocess_;
  WorldPose sensor_pose_;
  io::CloudEncoder cloud_encoder_;
  io::FrameDecoder frame_decoder_;
  io::OctreePointCloudIntensityCompression<pcl::PointXYZI> encoder_;
  io::OctreePointCloudIntensityCompression<pcl::PointXYZI> decoder_;
  PositionCloud raw_;
  IntensityCloud::Ptr points_{new IntensityCloud};
  io::VoxelFrame voxels_;
  io::VoxelFrame decoded_voxels_;
  std::vector<std::uint8_t> bytes_;
  FrameBuffer buffer_;
  std::iostream stream_{&buffer_};
  IntensityCloud::Ptr decoded_{new IntensityCloud};
};

/** \brief SensorNode, from the message to bytes in one pass. */
class TimedSensorNode : public TimedCoder {
public:
  TimedSensorNode(const InputStream& stream,
                  const Workload& workload,
                  const Variant& variant)
  : sensor_pose_(stream.clouds->sensorPose()), node_([&] {
    nodes::SensorNodeSettings settings;
    settings.compression = compressionSettings(workload, variant);
    settings.law = workload.law;
    settings.crop_box = stream.crop_box;
    return settings;
  }())
  {}

  FrameTimes
  run(const InputFrame& frame) override
  {
    pcl::toPCLPointCloud2(*frame.raw, message_);
    FrameTimes times;
    times.class_encode_ms = timeOf([&] {
      const nodes::SensorNodeStatus status =
          node_.encode(message_, sensor_pose_, bytes_);
      if (!status.ok())
        throw std::runtime_error(status.message());
    });
    times.bytes = bytes_.size();
    return times;
  }

private:
  WorldPose sensor_pose_;
  nodes::SensorNode node_;
  pcl::PCLPointCloud2 message_;
  std::vector<std::uint8_t> bytes_;
};

class TimedPcl : public TimedCoder {
public:
  TimedPcl(const InputStream& stream, const Workload& workload)
  : sensor_pose_(stream.clouds->sensorPose().cast<float>().matrix())
  , encoder_({workload.resolution, workload.resolution, true, workload.i_frame_rate})
  {
    Eigen::Vector4f min = Eigen::Vector4f::Ones();
    Eigen::Vector4f max = Eigen::Vector4f::Ones();
    min.head<3>() = Eigen::Vector3d(stream.crop_box->min.data()).cast<float>();
    max.head<3>() = Eigen::Vector3d(stream.crop_box->max.data()).cast<float>();
    crop_box_.setMin(min);
    crop_box_.setMax(max);
  }

  FrameTimes
  run(const InputFrame& frame) override
  {
    *raw_ = *frame.raw;
    FrameTimes times;
    times.preprocess_ms = timeOf([&] {
      pcl::transformPointCloud(*raw_, *moved_, sensor_pose_);
      crop_box_.setInputCloud(moved_);
      crop_box_.filter(*cropped_);
    });
    buffer_.restart();
    stream_.clear();
    times.class_encode_ms = timeOf([&] { encoder_.encode(cropped_, stream_); });
    times.bytes = buffer_.size();
    // A point on a face of the box may fall on either side when it is moved.
    const double kept = static_cast<double>(cropped_->size());
    const double expected = static_cast<double>(frame.points->size());
    if (std::abs(kept - expected) > 0.001 * expected)
      throw std::runtime_error("it keeps " + std::to_string(cropped_->size()) +
                               " points of " + std::to_string(frame.points->size()));
    return times;
  }

private:
  Eigen::Matrix4f sensor_pose_;
  pcl::CropBox<pcl::PointXYZ> crop_box_;
  PclCompression<pcl::PointXYZ> encoder_;
  PositionCloud::Ptr raw_{new PositionCloud};
  PositionCloud::Ptr moved_{new PositionCloud};
  PositionCloud::Ptr cropped_{new PositionCloud};
  FrameBuffer buffer_;
  std::iostream stream_{&buffer_};
};

struct NamedCoder {
  std::string name;
  std::function<std::shared_ptr<TimedCoder>()> make;
};

std::vector<NamedCoder>
variantCoders(const InputStream& stream, const Workload& workload, bool times_stages)
{
  std::vector<NamedCoder> coders;
  for (const Variant& variant : libraryVariants())
    coders.push_back({coderName(variant), [&stream, workload, variant, times_stages] {
                        return std::make_shared<TimedVariant>(
                            stream, workload, variant, times_stages);
                      }});
  return coders;
}

/** \brief A process that makes a new coder for frame 0. */
ProcessOf<FrameTimes>
startProcess(const NamedCoder& coder, const std::vector<InputFrame>& frames)
{
  return ProcessOf<FrameTimes>(coder.name, [&frames, make = coder.make] {
    return [&frames, make, timed = std::shared_ptr<TimedCoder>()](
               std::size_t index) mutable {
      if (index == 0)
        timed = make();
      return timed->run(frames[index]);
    };
  });
}

void
addFrame(std::size_t index, const FrameTimes& frame, StageTimes& times)
{
  times.preprocess.keepLeast(index, frame.preprocess_ms);
  times.voxelize.keepLeast(index, frame.voxelize_ms);
  times.code.keepLeast(index, frame.code_ms);
  times.decode.keepLeast(index, frame.decode_ms);
  times.class_encode.keepLeast(index, frame.class_encode_ms);
  times.class_decode.keepLeast(index, frame.class_decode_ms);
  times.raw_to_bytes.keepLeast(index, frame.preprocess_ms + frame.class_encode_ms);
  times.bytes.keepLeast(index, static_cast<double>(frame.bytes));
}

std::vector<StageTimes>
timeCoders(const InputStream& stream,
           const Workload& workload,
           const std::vector<NamedCoder>& coders,
           std::size_t repetitions)
{
  const std::vector<InputFrame> frames = readFrames(stream, workload, Keep::All);
  std::vector<StageTimes> times(coders.size());
  std::vector<ProcessOf<FrameTimes>> processes;
  for (std::size_t i = 0; i < coders.size(); ++i) {
    times[i].name = coders[i].name;
    processes.push_back(startProcess(coders[i], frames));
  }
  takeTurns(stream.clouds->name(),
            frames.size(),
            repetitions,
            processes,
            [&times](std::size_t which, std::size_t index, const FrameTimes& frame) {
              addFrame(index, frame, times[which]);
            });
  return times;
}

} // namespace

std::vector<StageTimes>
timeStages(const InputStream& stream, const Workload& workload, std::size_t repetitions)
{
  return timeCoders(stream,
                    workload,
                    variantCoders(stream, workload, /* times_stages */ true),
                    repetitions);
}

std::vector<StageTimes>
timeRawToBytes(const InputStream& stream,
               const Workload& workload,
               std::size_t repetitions)
{
  std::vector<NamedCoder> coders =
      variantCoders(stream, workload, /* times_stages */ false);
  const Variant& fastest = libraryVariants().front();
  coders.push_back({std::string(sensor_node_name) + ", " + fastest.name,
                    [&stream, workload, fastest] {
                      return std::make_shared<TimedSensorNode>(
                          stream, workload, fastest);
                    }});
  coders.push_back({pcl_voxel_grid_name, [&stream, workload] {
                      return std::make_shared<TimedPcl>(stream, workload);
                    }});
  return timeCoders(stream, workload, coders, repetitions);
}

} // namespace measuring
} // namespace pcl_ext
