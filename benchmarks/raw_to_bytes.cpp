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
namespace benchmarks {

namespace {

/** \brief One way from the sensor's cloud to bytes. */
class RawToBytes {
public:
  RawToBytes(const std::string& name, const std::string& passes)
  {
    times_.name = name;
    times_.passes = passes;
  }

  virtual ~RawToBytes() = default;

  void
  run(const InputFrame& frame)
  {
    buffer_.restart();
    stream_.clear();
    const double move_and_crop_ms = timeOf([&] { moveAndCrop(frame.raw); });
    const double compress_ms = timeOf([&] { compress(stream_); });
    // A point on a face of the box may fall on either side when it is moved.
    const double kept = static_cast<double>(keptPoints());
    const double expected = static_cast<double>(frame.points->size());
    if (std::abs(kept - expected) > 0.001 * expected)
      throw std::runtime_error(times_.name + " keeps " + std::to_string(keptPoints()) +
                               " points of " + std::to_string(frame.points->size()));
    times_.move_and_crop.add(move_and_crop_ms);
    times_.compress.add(compress_ms);
    times_.total.add(move_and_crop_ms + compress_ms);
    times_.bytes.add(static_cast<double>(buffer_.size()));
  }

  const RawToBytesTimes&
  times() const
  {
    return times_;
  }

private:
  virtual void
  moveAndCrop(const PositionCloud::ConstPtr& raw) = 0;

  virtual void
  compress(std::ostream& bytes) = 0;

  virtual std::size_t
  keptPoints() const = 0;

  RawToBytesTimes times_;
  FrameBuffer buffer_;
  std::iostream stream_{&buffer_};
};

class LibraryRawToBytes : public RawToBytes {
public:
  LibraryRawToBytes(const InputStream& stream,
                    const Workload& workload,
                    const Variant& variant)
  : RawToBytes(coderName(variant), "SensorPreprocessor, class")
  , preprocess_(
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
  : RawToBytes("PCL, voxel grid", "transformPointCloud, CropBox, class")
  , sensor_pose_(stream.clouds->sensorPose().cast<float>().matrix())
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

} // namespace

std::vector<RawToBytesTimes>
timeRawToBytes(const InputStream& stream, const Workload& workload)
{
  std::vector<std::unique_ptr<RawToBytes>> ways;
  for (const Variant& variant : libraryVariants())
    ways.push_back(std::make_unique<LibraryRawToBytes>(stream, workload, variant));
  ways.push_back(std::make_unique<PclRawToBytes>(stream, workload));
  takeTurns(stream, workload, ways);
  std::vector<RawToBytesTimes> times;
  for (const auto& way : ways)
    times.push_back(way->times());
  return times;
}

} // namespace benchmarks
} // namespace pcl_ext
