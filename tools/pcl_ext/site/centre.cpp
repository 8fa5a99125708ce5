// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "site/centre.h"

#include <pcl_ext/compression/frame_description.h>

#include "console/exit_status.h"
#include "console/interruption.h"
#include "console/throw_unless_ok.h"
#include "inputs/stream_metadata.h"
#include "measuring/markdown_table.h"
#include "options/setting_options.h"
#include "streams/stream_decoder.h"

#include <algorithm>
#include <sstream>
#include <utility>

namespace pcl_ext::tools {

namespace {

nodes::FrameListener
requestingListener(const Centre::RequestIFrame& request_i_frame)
{
  return [request_i_frame](const nodes::ReceivedFrame& frame) {
    if (frame.wants_i_frame)
      request_i_frame(frame.stream);
  };
}

io::FrameDescription
describe(const link::LinkFrame& frame)
{
  return io::describeFrame(
      frame.bytes.data(), frame.bytes.size(), io::DecoderLimits::none());
}

} // namespace

Centre::Grid::Grid(Centre& centre_of_site, double merged_resolution)
: resolution(merged_resolution)
, encoder(centre_of_site.options_.stream)
, centre(centre_of_site.settingsOf(merged_resolution),
         requestingListener(centre_of_site.request_i_frame_),
         [&centre_of_site](const nodes::MergedFrame& merged) {
           centre_of_site.publish(merged);
         })
{
  const CentreMapOptions& map_options = centre_of_site.options_.map;
  if (!map_options.path.empty())
    map.emplace(map_options, merged_resolution, centre_of_site.console_);
  if (!centre.settingsStatus().ok())
    throw UsageError(messageOf(centre.settingsStatus()));
  centre.setMerging(true);
}

Centre::Centre(const CentreOptions& options,
               RequestIFrame request_i_frame,
               Console& console)
: options_(options), request_i_frame_(std::move(request_i_frame)), console_(console)
{
  // Without a resolution for what is wrong with the others.
  makeGrid(options.resolution.value_or(nodes::CentralNodeSettings().resolution));
  if (!options.resolution)
    grid_.reset();
}

nodes::MergingCentreSettings
Centre::settingsOf(double resolution) const
{
  nodes::MergingCentreSettings settings;
  settings.node.resolution = resolution;
  settings.node.decoder_limits = options_.decoding.limits;
  settings.schedule = options_.schedule;
  settings.node.max_merge_age = options_.schedule.max_age;
  if (options_.is_replay) { // as the frames came then, not as they are decoded now
    settings.node.max_merge_age = nodes::Time(1);
    settings.arrival_clock = [this] { return kept_; };
  }
  settings.schedule.skips_late = !options_.is_replay;
  settings.has_thread = false;
  if (!options_.is_replay) // frames are taken while others are decoded
    settings.turn = std::chrono::milliseconds(5);
  return settings;
}

void
Centre::makeGrid(double resolution)
{
  auto grid = std::make_unique<Grid>(*this, resolution);
  const std::lock_guard<std::mutex> lock(grid_mutex_);
  grid_ = std::move(grid);
}

std::vector<nodes::StreamHealth>
Centre::health() const
{
  const std::lock_guard<std::mutex> lock(grid_mutex_);
  return grid_ ? grid_->centre.node().health() : std::vector<nodes::StreamHealth>();
}

double
Centre::mergedResolution() const
{
  const std::lock_guard<std::mutex> lock(grid_mutex_);
  return grid_ ? grid_->resolution : 0.0;
}

nodes::MergeCounts
Centre::mergeCounts() const
{
  const std::lock_guard<std::mutex> lock(grid_mutex_);
  return grid_ ? grid_->centre.mergeCounts() : nodes::MergeCounts();
}

std::optional<nodes::MapCounts>
Centre::mapCounts() const
{
  if (options_.map.path.empty())
    return std::nullopt;
  const std::lock_guard<std::mutex> lock(grid_mutex_);
  return grid_ ? grid_->map->counts() : nodes::MapCounts();
}

void
Centre::addOutput(LiveOutput& output)
{
  outputs_.push_back({&output, output.addStream(options_.name, {})});
}

bool
Centre::addStream(const link::LinkFrame& frame)
{
  const auto added = grid_->centre.addStream(frame.stream);
  if (!added.ok()) {
    console_.error(frame.stream + ": it is left out: " + added.message());
    return false;
  }
  nodes::CentralNode& node = grid_->centre.node();
  if (options_.decoding.min_intensity)
    node.setMinIntensity(frame.stream, *options_.decoding.min_intensity);
  if (options_.decoding.min_intensity && describe(frame).intensity_scale.bits == 0)
    console_.remark(remarkWithoutIntensities(frame.stream));
  applyMetadata(frame);
  return true;
}

void
Centre::setOutlierRemoval(const link::LinkFrame& frame)
{
  // The frame is not decoded yet, so that it may have numbers of points.
  std::string fault = unitFaultOf(options_.decoding, frame.metadata, true);
  if (fault.empty())
    if (const auto set = grid_->centre.node().setOutlierRemoval(
            frame.stream,
            outlierRemovalOf(options_.decoding, frame.metadata, io::VoxelFrame()));
        !set.ok())
      fault = set.message();
  if (!fault.empty())
    console_.error(frame.stream + ": its outliers stay: " + fault);
}

void
Centre::applyMetadata(const link::LinkFrame& frame)
{
  if (options_.decoding.removes_outliers)
    setOutlierRemoval(frame);
  if (grid_->map)
    grid_->map->setMetadata(frame.stream, frame.metadata, frame.time);
}

void
Centre::take(const link::LinkFrame& frame)
{
  if (!grid_) {
    // The first frame that comes is an I-frame. Whether it is too large to be decoded is
    // found, and told, when that is tried.
    const io::FrameDescription first = describe(frame);
    std::ostringstream remark;
    remark << "voxels have the edge of those of " << frame.stream << ", "
           << first.grid.resolution << " m; --resolution sets another";
    console_.remark(remark.str());
    makeGrid(first.grid.resolution);
  }
  if (options_.is_replay) {
    kept_ = std::max(kept_, frame.kept);
    work(); // what was due before this frame came
  }
  auto found = streams_.find(frame.stream);
  const bool has_changed = metadata_changes_.take(frame);
  if (found == streams_.end())
    found = streams_.emplace(frame.stream, addStream(frame)).first;
  else if (has_changed && found->second)
    applyMetadata(frame);
  if (found->second) { // one that is too fast for this machine is in the statistics
    grid_->centre.receive(frame.stream, frame.bytes, frame.time);
    if (grid_->centre.stampsRepeated(frame.stream) > 0 &&
        repeating_streams_.insert(frame.stream).second)
      console_.remark(frame.stream +
                      ": frames have the time of the one before; they are merged as "
                      "they arrive");
  }
  if (frame.is_i_frame)
    has_slow_effort_ |= describe(frame).effort != io::Effort::Fast;
}

bool
Centre::hasLeftOut() const
{
  const bool has_no_map = grid_ && grid_->map && grid_->map->isLeftOut();
  return has_no_map || std::any_of(streams_.begin(),
                                   streams_.end(),
                                   [](const auto& stream) { return !stream.second; });
}

void
Centre::work()
{
  if (grid_)
    grid_->centre.work();
}

void
Centre::countMissing(const nodes::MergedFrame& merged)
{
  std::vector<nodes::StreamHealth> streams; // those of now, if one is missing
  for (const nodes::MergedSource& source : merged.sources) {
    if (source.stamp) {
      merged_streams_.insert(source.name);
      continue;
    }
    if (streams.empty())
      streams = grid_->centre.node().health();
    const auto stream = std::find_if(
        streams.begin(), streams.end(), [&source](const nodes::StreamHealth& one) {
          return one.name == source.name;
        });
    if (stream != streams.end() && stream->lacks_voxels)
      ++missing_[source.name].dropped;
    else if (stream != streams.end() && stream->frames_failed > 0 && !stream->in_sync)
      ++missing_[source.name].undecodable;
    else if (merged_streams_.count(source.name) > 0)
      ++missing_[source.name].old;
  }
}

void
Centre::tellOfClocks(const nodes::MergedFrame& merged)
{
  for (const std::string& stream : merged.other_clocks)
    if (repeating_streams_.count(stream) == 0 && other_clocks_.insert(stream).second)
      console_.remark(stream +
                      ": its clock is more than 2 s from that of the other streams; it "
                      "is merged as it arrives");
  const auto before = std::exchange(merged_time_, merged.time);
  if (before && *before > merged.time)
    console_.remark(
        "merged times go back by " +
        measuring::formatted(
            std::chrono::duration<double>(*before - merged.time).count(), 1) +
        " s, to the clock of the streams that come now");
}

void
Centre::publish(const nodes::MergedFrame& merged)
{
  throwUnlessOk(merged.status);
  tellOfClocks(merged);
  if (grid_->map)
    grid_->map->update(grid_->centre.node(), merged.time);
  if (outputs_.empty())
    return;
  countMissing(merged);
  if (requests_.take())
    grid_->encoder.requestIFrame();
  std::vector<std::uint8_t> bytes;
  throwUnlessOk(
      grid_->encoder.encode(merged.changes, merged.voxels, merged.time, "", bytes));
  requests_.countFrame();
  for (const Output& output : outputs_)
    output.output->publish(output.stream, merged.time, bytes);
}

void
Centre::finish()
{
  if (!grid_)
    return;
  constexpr std::chrono::seconds patience{1};
  constexpr std::chrono::seconds patience_of_merging{2};
  if (!options_.is_replay)
    grid_->centre.finish(patience_of_merging);
  else if (!isInterrupted())
    grid_->centre.finish(std::nullopt);
  nodes::CentralNode& node = grid_->centre.node();
  if (options_.is_replay)
    node.waitUntilDecoded();
  else if (!node.waitUntilDecoded(patience))
    node.refuseWaiting();
  if (grid_->map)
    grid_->map->finish(node);
}

} // namespace pcl_ext::tools
