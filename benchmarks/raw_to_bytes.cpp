#include "raw_to_bytes.h"

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "frame_buffer.h"
#include "pcl_compression.h"
#include "take_turns.h"

#include <pcl/common/transforms.h>
#include <pcl/filters/crop_box.h>

#include <cmath>
#include <istream>
#include <memory>
#include <stdexcept>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief What one frame took; goes from the way's process to the parent's. */
struct FrameTimes {
  double move_and_crop_ms = 0.0;
  double compress_ms = 0.0;
  std::size_t bytes = 0;
};

/** \brief One way from the sensor's cloud to bytes. */
class RawToBytes {
public:
  virtual ~RawToBytes() = default;

  FrameTimes
  run(const InputFrame& frame)
  {
    buffer_.restart();
    stream_.clear();
    // As a driver's, the cloud has just been written when it comes.
    *raw_ = *frame.raw;
    FrameTimes times;
    times.move_and_crop_ms = timeOf([&] { moveAndCrop(raw_); });
    times.compress_ms = timeOf([&] { compress(stream_); });
    times.bytes = buffer_.size();
    // A point on a face of the box may fall on either side when it is moved.
    const double kept = static_cast<double>(keptPoints());
    const double expected = static_cast<double>(frame.points->size());
    if (std::abs(kept - expected) > 0.001 * expected)
      throw std::runtime_error("it keeps " + std::to_string(keptPoints()) +
                               " points of " + std::to_string(frame.points->size()));
    return times;
  }

private:
  virtual void
  moveAndCrop(const PositionCloud::ConstPtr& raw) = 0;

  virtual void
  compress(std::ostream& bytes) = 0;

  virtual std::size_t
  keptPoints() const = 0;

  PositionCloud::Ptr raw_{new PositionCloud};
  FrameBuffer buffer_;
  std::iostream stream_{&buffer_};
};

class LibraryRawToBytes : public RawToBytes {
public:
  LibraryRawToBytes(const InputStream& stream,
                    const Workload& workload,
                    const Variant& variant)
  : preprocess_(
        makePreprocessing(workload, stream.clouds->sensorPose(), stream.crop_box))
  , encoder_(compressionSettings(workload, variant))
  {}

private:
  void
  moveAndCrop(const PositionCloud::ConstPtr& raw) override
  {
    preprocess_(*raw, *points_);
  }

  void
  compress(std::ostream& bytes) override
  {
    if (const auto status = encoder_.encodePointCloud(points_, bytes); !status.ok())
      throw std::runtime_error(status.message());
  }

  std::size_t
  keptPoints() const override
  {
    return points_->size();
  }

  Preprocessing preprocess_;
  io::OctreePointCloudIntensityCompression<pcl::PointXYZI> encoder_;
  IntensityCloud::Ptr points_{new IntensityCloud};
};

class PclRawToBytes : public RawToBytes {
public:
  PclRawToBytes(const InputStream& stream, const Workload& workload)
  : sensor_pose_(stream.clouds->sensorPose().cast<float>().matrix())
  , encoder_({workload.resolution, workload.resolution, true, workload.i_frame_rate})
  {
    if (!stream.crop_box)
      throw std::runtime_error("there is no crop box to compare with PCL's");
    Eigen::Vector4f min = Eigen::Vector4f::Ones();
    Eigen::Vector4f max = Eigen::Vector4f::Ones();
    for (int axis = 0; axis < 3; ++axis) {
      min[axis] =
          static_cast<float>(stream.crop_box->min[static_cast<std::size_t>(axis)]);
      max[axis] =
          static_cast<float>(stream.crop_box->max[static_cast<std::size_t>(axis)]);
    }
    crop_box_.setMin(min);
    crop_box_.setMax(max);
  }

private:
  void
  moveAndCrop(const PositionCloud::ConstPtr& raw) override
  {
    pcl::transformPointCloud(*raw, *moved_, sensor_pose_);
    crop_box_.setInputCloud(moved_);
    crop_box_.filter(*cropped_);
  }

  void
  compress(std::ostream& bytes) override
  {
    encoder_.encode(cropped_, bytes);
  }

  std::size_t
  keptPoints() const override
  {
    return cropped_->size();
  }

  Eigen::Matrix4f sensor_pose_;
  pcl::CropBox<pcl::PointXYZ> crop_box_;
  PclCompression encoder_;
  PositionCloud::Ptr moved_{new PositionCloud};
  PositionCloud::Ptr cropped_{new PositionCloud};
};

ProcessOf<FrameTimes>
startWay(const std::string& name,
         const std::vector<InputFrame>& frames,
         const std::function<std::shared_ptr<RawToBytes>()>& make_way)
{
  return ProcessOf<FrameTimes>(name, [&frames, make_way] {
    return [&frames, make_way, way = std::shared_ptr<RawToBytes>()](
               std::size_t index) mutable {
      if (index == 0)
        way = make_way();
      return way->run(frames[index]);
    };
  });
}

} // namespace

std::vector<RawToBytesTimes>
timeRawToBytes(const InputStream& stream,
               const Workload& workload,
               std::size_t repetitions)
{
  const std::vector<InputFrame> frames = readFrames(stream, workload, Keep::All);
  std::vector<RawToBytesTimes> times;
  std::vector<ProcessOf<FrameTimes>> processes;
  const auto start = [&](const std::string& name,
                         const std::string& passes,
                         const std::function<std::shared_ptr<RawToBytes>()>& make_way) {
    times.emplace_back();
    times.back().name = name;
    times.back().passes = passes;
    processes.push_back(startWay(name, frames, make_way));
  };
  for (const Variant& variant : libraryVariants())
    start(
        coderName(variant), "SensorPreprocessor, class", [&stream, workload, variant] {
          return std::make_shared<LibraryRawToBytes>(stream, workload, variant);
        });
  start("PCL, voxel grid", "transformPointCloud, CropBox, class", [&stream, workload] {
    return std::make_shared<PclRawToBytes>(stream, workload);
  });
  takeTurns(stream.clouds->name(),
            frames.size(),
            repetitions,
            processes,
            [&times](std::size_t which, std::size_t index, const FrameTimes& frame) {
              times[which].move_and_crop.keepLeast(index, frame.move_and_crop_ms);
              times[which].compress.keepLeast(index, frame.compress_ms);
              times[which].total.keepLeast(index,
                                           frame.move_and_crop_ms + frame.compress_ms);
              times[which].bytes.keepLeast(index, static_cast<double>(frame.bytes));
            });
  return times;
}

} // namespace measuring
} // namespace pcl_ext
