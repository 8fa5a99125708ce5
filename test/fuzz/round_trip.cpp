// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * Fuzz target: any points, as a stream of clouds, come back as the voxels that went in,
 * in either format and with each effort, with and without a depth law; and encoding the
 * decoded frames again gives the same bytes. Of the decoded frames the
 * outlier filter keeps the voxels whose log-odds reach its threshold, and no others;
 * what the temporal filter shows of them is a valid frame.
 */
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/filters/temporal_voxel_filter.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "fuzz_input.h"
#include "stream/frame_encoder.h"
#include "voxelizing/voxelizer.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::io;
using pcl_ext::fuzz::require;

IntensityCompressionSettings
settingsOf(std::uint8_t choice, bool is_companded)
{
  IntensityCompressionSettings settings;
  settings.resolution = (choice & 1) != 0 ? 0.04 : 1000.0;
  settings.format =
      (choice & 2) != 0 ? StreamFormat::Published : StreamFormat::Version1;
  settings.i_frame_rate = 3;
  if (settings.format == StreamFormat::Version1) {
    settings.intensity_bits = choice >> 4;
    settings.intensity_curve =
        is_companded ? IntensityCurve::Companded : IntensityCurve::Linear;
  }
  if ((choice & 4) != 0)
    settings.bounding_box = BoundingBox{{-3.0, -2.0, 0.1}, {3.0, 2.5, 4.0}};
  return settings;
}

/** \brief What is chosen besides the voxelizer's settings. */
struct Choices {
  explicit Choices(std::uint8_t byte)
  : points_per_cloud(1 + byte % 64)
  , effort(static_cast<Effort>(byte / 64 % 3))
  , repetitions(byte % 3 + 1)
  {}

  std::size_t points_per_cloud;
  Effort effort;
  /** \brief Frames of each cloud, so that P-frames have tracked voxels. */
  std::size_t repetitions;
};

/** \brief A depth model of a frame's own grid, or none. */
std::optional<DepthModel>
depthModel(const VoxelFrame& frame, std::uint8_t choice, std::size_t cloud)
{
  if (choice % 2 == 0)
    return std::nullopt;
  DepthLaw law;
  law.exponent = 1 + choice / 2 % 2;
  law.cut_off_depth = 0.01 * (1 + choice);
  law.full_intensity = static_cast<double>(1 << choice / 16);
  // A sensor that moves now and then.
  const double place = static_cast<double>(cloud / 2);
  return depthModelOf(
      law, {place, 0.0, -place}, {0.0, 0.6, 0.8}, frame.grid, frame.intensity_scale);
}

VoxelOutlierRemovalSettings
removalSettingsOf(std::uint8_t choice)
{
  return {densityUnitSettings(static_cast<DensityUnit>(choice / 4 % 5),
                              {{choice % 8 != 7}, choice % 3 == 0}),
          static_cast<float>(choice % 16) - 8.0f,
          choice % 32 < 16 ? 4u : 1000u};
}

/** \brief Two filters of one stream of frames: one that removes and one that judges. */
class CheckedRemoval {
public:
  explicit CheckedRemoval(const VoxelOutlierRemovalSettings& settings)
  : settings_(settings), filter_(settings), judge_(settings)
  {
    require(checkSettings(settings).ok());
  }

  void
  take(const VoxelFrame& frame)
  {
    VoxelFrame filtered = frame;
    const OutlierRemovalStatus status = filter_.filter(filtered);
    const std::size_t removed = status.removed;
    std::vector<float> log_odds;
    require(judge_.score(frame, log_odds).code() == status.code());
    require(log_odds.size() == frame.size());
    require(filter_.rememberedBlocks() <= settings_.max_blocks);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < frame.size(); ++i) {
      if (log_odds[i] < settings_.min_log_odds)
        continue;
      require(kept < filtered.size() && filtered.keys[kept] == frame.keys[i] &&
              filtered.intensities[kept] == frame.intensities[i]);
      ++kept;
    }
    require(filtered.size() == kept && isConsistent(filtered));
    require(kept + removed == frame.size());
    require(removed == 0 || status.ok());
  }

private:
  VoxelOutlierRemovalSettings settings_;
  VoxelOutlierRemoval filter_;
  VoxelOutlierRemoval judge_;
};

/** \brief Filters a frame over time. */
void
requireShown(TemporalVoxelFilter& filter, VoxelFrame frame, std::uint8_t choice)
{
  const std::vector<std::uint64_t> keys = frame.keys;
  std::optional<std::array<double, 3>> position;
  if (choice % 4 != 0)
    position = {0.1 * choice, -0.1 * choice, frame.grid.centre(2, 0)};
  const TemporalFilterStatus status =
      filter.filter(frame, {position, std::chrono::milliseconds(choice * choice)});
  require(status.ok() && isConsistent(frame));
  require(status.hidden <= keys.size() && status.held <= frame.size());
  require(keys.size() - status.hidden == frame.size() - status.held);
}

void
requireRoundTrip(StreamFormat format,
                 const VoxelFrame& frame,
                 FrameEncoder& encoder,
                 FrameEncoder& second_encoder,
                 FrameDecoder& decoder,
                 CheckedRemoval& removal)
{
  std::vector<std::uint8_t> bytes;
  std::vector<std::uint8_t> bytes_again;
  VoxelFrame decoded;
  require(encoder.encode(frame, std::nullopt, bytes).ok());
  require(decoder.decode(bytes.data(), bytes.size(), decoded).ok());
  require(decoded.keys == frame.keys && decoded.intensities == frame.intensities);
  require(decoded.intensity_scale == frame.intensity_scale);
  require(decoder.statistics().occupancy_bytes == encoder.statistics().occupancy_bytes);
  // The published layout stores the box of a grid, not its place on a lattice.
  // A depth model that costs bytes is left out; what was offered decides the same
  // again.
  if (format == StreamFormat::Version1)
    require(decoded.grid == frame.grid &&
            (!decoded.depth_model || decoded.depth_model == frame.depth_model));
  removal.take(decoded);
  decoded.depth_model = frame.depth_model;
  require(second_encoder
              .encode(format == StreamFormat::Version1 ? decoded : frame,
                      std::nullopt,
                      bytes_again)
              .ok());
  require(bytes == bytes_again);
}

/** \brief A voxel less, and the others' intensities a little different. */
void
forgetOne(VoxelFrame& frame)
{
  if (frame.keys.empty())
    return;
  const auto middle = static_cast<std::ptrdiff_t>(frame.keys.size() / 2);
  frame.keys.erase(frame.keys.begin() + middle);
  frame.intensities.erase(frame.intensities.begin() + middle);
  for (std::size_t i = 0; i < frame.intensities.size(); i += 3)
    frame.intensities[i] = static_cast<std::uint16_t>(
        (frame.intensities[i] + 1u) & frame.intensity_scale.maxSymbol());
}

} // namespace

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  if (size < 3)
    return 0;
  const IntensityCompressionSettings settings =
      settingsOf(data[0], data[2] % 4 == 2); // which has no depth model
  require(checkSettings(settings).ok());
  const Choices choices(data[1]);
  std::vector<float> numbers((size - 3) / sizeof(float));
  if (!numbers.empty())
    std::memcpy(numbers.data(), data + 3, numbers.size() * sizeof(float));

  const IntensityUnit unit =
      (data[0] & 8) != 0 ? IntensityUnit::Native : IntensityUnit::Share;
  Voxelizer voxelizer(settings, unit);
  FrameEncoder encoder(settings.format, settings.i_frame_rate, choices.effort);
  FrameEncoder second_encoder(settings.format, settings.i_frame_rate, choices.effort);
  FrameDecoder decoder;
  CheckedRemoval removal(removalSettingsOf(data[1]));
  TemporalVoxelFilter filter(2 + data[1] % 63);
  VoxelFrame frame;
  const std::size_t step = 4 * choices.points_per_cloud;
  for (std::size_t begin = 0; begin < numbers.size(); begin += step) {
    const std::size_t points = (numbers.size() - begin) / 4;
    PointView view;
    view.coordinates = numbers.data() + begin;
    view.intensities = view.coordinates + 3;
    view.coordinate_stride = view.intensity_stride = 4 * sizeof(float);
    view.count = std::min(points, choices.points_per_cloud);
    const VoxelizationStatistics statistics =
        voxelizer.voxelize(view, encoder.isIFrameDue(), frame);
    require(statistics.points_used + statistics.points_not_finite +
                statistics.points_outside_box + statistics.points_outside_grid ==
            view.count);
    if (settings.format == StreamFormat::Version1)
      frame.depth_model = depthModel(frame, data[2], begin / step);
    for (std::size_t i = 0; i < choices.repetitions; ++i) {
      requireRoundTrip(
          settings.format, frame, encoder, second_encoder, decoder, removal);
      requireShown(filter, frame, data[2]);
      forgetOne(frame);
    }
  }
  return 0;
}
