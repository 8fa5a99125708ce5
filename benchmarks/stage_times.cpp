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
namespace benchmarks {

namespace {

using Compression = io::OctreePointCloudIntensityCompression<pcl::PointXYZI>;

void
demand(const io::CompressionStatus& status)
{
  if (!status.ok())
    throw std::runtime_error(status.message());
}

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
  {
    times_.name = coderName(variant);
  }

  void
  run(const InputFrame& frame)
  {
    times_.preprocess.add(timeOf([&] { preprocess_(*frame.raw, *points_); }));
    const io::PointView view = viewOf(*points_);
    times_.voxelize.add(timeOf(
        [&] { voxelizer_.voxelize(view, frame_encoder_.isIFrameDue(), voxels_); }));
    times_.code.add(
        timeOf([&] { demand(frame_encoder_.encode(voxels_, std::nullopt, bytes_)); }));
    const double decode_ms = timeOf([&] {
      demand(frame_decoder_.decode(bytes_.data(), bytes_.size(), decoded_voxels_));
    });
    times_.decode.add(decode_ms);
    buffer_.restart();
    stream_.clear();
    times_.class_encode.add(
        timeOf([&] { demand(encoder_.encodePointCloud(points_, stream_)); }));
    const double class_decode_ms =
        timeOf([&] { demand(decoder_.decodePointCloud(stream_, decoded_)); });
    times_.class_decode.add(class_decode_ms);
    times_.fill_cloud.add(class_decode_ms - decode_ms);
    if (!isSame(voxels_, decoded_voxels_) || !isSame(voxels_, decoder_.getVoxelFrame()))
      throw std::runtime_error(times_.name +
                               ": it was not decoded to what was encoded");
  }

  const StageTimes&
  times() const
  {
    return times_;
  }

private:
  static bool
  isSame(const io::VoxelFrame& a, const io::VoxelFrame& b)
  {
    return a.keys == b.keys && a.intensities == b.intensities;
  }

  io::IntensityCompressionSettings settings_;
  StageTimes times_;
  Preprocessing preprocess_;
  io::Voxelizer voxelizer_;
  io::FrameEncoder frame_encoder_;
  io::FrameDecoder frame_decoder_;
  Compression encoder_;
  Compression decoder_;
  IntensityCloud::Ptr points_{new IntensityCloud};
  io::VoxelFrame voxels_;
  io::VoxelFrame decoded_voxels_;
  std::vector<std::uint8_t> bytes_;
  FrameBuffer buffer_;
  std::iostream stream_{&buffer_};
  IntensityCloud::Ptr decoded_{new IntensityCloud};
};

} // namespace

io::PointView
viewOf(const IntensityCloud& points)
{
  constexpr std::size_t floats_per_point = sizeof(pcl::PointXYZI) / sizeof(float);
  io::PointView view;
  view.count = points.size();
  view.coordinates = &points.front().x;
  view.coordinate_stride = floats_per_point;
  view.intensities = &points.front().intensity;
  view.intensity_stride = floats_per_point;
  return view;
}

io::FrameEncoder
makeFrameEncoder(const io::IntensityCompressionSettings& settings)
{
  return io::FrameEncoder(settings.format, settings.i_frame_rate);
}

std::vector<StageTimes>
timeStages(const InputStream& stream, const Workload& workload)
{
  std::vector<std::unique_ptr<TimedVariant>> variants;
  for (const Variant& variant : libraryVariants())
    variants.push_back(std::make_unique<TimedVariant>(stream, workload, variant));
  takeTurns(stream, workload, variants);
  std::vector<StageTimes> times;
  for (const auto& variant : variants)
    times.push_back(variant->times());
  return times;
}

} // namespace benchmarks
} // namespace pcl_ext
