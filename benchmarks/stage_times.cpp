#include "stage_times.h"

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/compression/voxelizer.h>

#include "frame_buffer.h"
#include "take_turns.h"

#include <cstdint>
#include <istream>
#include <memory>
#include <optional>
#include <stdexcept>

namespace pcl_ext {
namespace measuring {

namespace {

using Compression = io::OctreePointCloudIntensityCompression<pcl::PointXYZI>;

void
demand(const io::CompressionStatus& status)
{
  if (!status.ok())
    throw std::runtime_error(status.message());
}

/** \brief What the stages of one frame took; goes from the variant's process to the
 * parent's. */
struct FrameStages {
  double preprocess_ms = 0.0;
  double voxelize_ms = 0.0;
  double code_ms = 0.0;
  double decode_ms = 0.0;
  double class_encode_ms = 0.0;
  double class_decode_ms = 0.0;
};

/** \brief All stages of one variant, by themselves and within the class. */
class TimedVariant {
public:
  TimedVariant(const InputStream& stream,
               const Workload& workload,
               const Variant& variant)
  : settings_(compressionSettings(workload, variant))
  , preprocess_(
        makePreprocessing(workload, stream.clouds->sensorPose(), stream.crop_box))
  , voxelizer_(settings_, IntensityUnit::Native)
  , frame_encoder_(makeFrameEncoder(settings_))
  , encoder_(settings_)
  , decoder_(settings_)
  {}

  FrameStages
  run(const InputFrame& frame)
  {
    // As a driver's, the cloud has just been written when it comes.
    raw_ = *frame.raw;
    FrameStages times;
    times.preprocess_ms = timeOf([&] { preprocess_(raw_, *points_); });
    const io::PointView view = viewOf(*points_);
    times.voxelize_ms = timeOf(
        [&] { voxelizer_.voxelize(view, frame_encoder_.isIFrameDue(), voxels_); });
    times.code_ms =
        timeOf([&] { demand(frame_encoder_.encode(voxels_, std::nullopt, bytes_)); });
    times.decode_ms = timeOf([&] {
      demand(frame_decoder_.decode(bytes_.data(), bytes_.size(), decoded_voxels_));
    });
    buffer_.restart();
    stream_.clear();
    times.class_encode_ms =
        timeOf([&] { demand(encoder_.encodePointCloud(points_, stream_)); });
    times.class_decode_ms =
        timeOf([&] { demand(decoder_.decodePointCloud(stream_, decoded_)); });
    if (!isSame(voxels_, decoded_voxels_) || !isSame(voxels_, decoder_.getVoxelFrame()))
      throw std::runtime_error("it was not decoded to what was encoded");
    return times;
  }

private:
  static bool
  isSame(const io::VoxelFrame& a, const io::VoxelFrame& b)
  {
    return a.keys == b.keys && a.intensities == b.intensities;
  }

  io::IntensityCompressionSettings settings_;
  Preprocessing preprocess_;
  io::Voxelizer voxelizer_;
  io::FrameEncoder frame_encoder_;
  io::FrameDecoder frame_decoder_;
  Compression encoder_;
  Compression decoder_;
  PositionCloud raw_;
  IntensityCloud::Ptr points_{new IntensityCloud};
  io::VoxelFrame voxels_;
  io::VoxelFrame decoded_voxels_;
  std::vector<std::uint8_t> bytes_;
  FrameBuffer buffer_;
  std::iostream stream_{&buffer_};
  IntensityCloud::Ptr decoded_{new IntensityCloud};
};

ProcessOf<FrameStages>
startVariant(const InputStream& stream,
             const std::vector<InputFrame>& frames,
             const Workload& workload,
             const Variant& variant)
{
  return ProcessOf<FrameStages>(
      coderName(variant), [&stream, &frames, workload, variant] {
        return [&stream,
                &frames,
                workload,
                variant,
                timed = std::shared_ptr<TimedVariant>()](std::size_t index) mutable {
          if (index == 0)
            timed = std::make_shared<TimedVariant>(stream, workload, variant);
          return timed->run(frames[index]);
        };
      });
}

} // namespace

std::vector<StageTimes>
timeStages(const InputStream& stream, const Workload& workload, std::size_t repetitions)
{
  const std::vector<InputFrame> frames = readFrames(stream, workload, Keep::All);
  std::vector<StageTimes> times;
  std::vector<ProcessOf<FrameStages>> processes;
  for (const Variant& variant : libraryVariants()) {
    times.emplace_back();
    times.back().name = coderName(variant);
    processes.push_back(startVariant(stream, frames, workload, variant));
  }
  takeTurns(stream.clouds->name(),
            frames.size(),
            repetitions,
            processes,
            [&times](std::size_t which, std::size_t index, const FrameStages& frame) {
              times[which].preprocess.keepLeast(index, frame.preprocess_ms);
              times[which].voxelize.keepLeast(index, frame.voxelize_ms);
              times[which].code.keepLeast(index, frame.code_ms);
              times[which].decode.keepLeast(index, frame.decode_ms);
              times[which].class_encode.keepLeast(index, frame.class_encode_ms);
              times[which].class_decode.keepLeast(index, frame.class_decode_ms);
            });
  return times;
}

} // namespace measuring
} // namespace pcl_ext
