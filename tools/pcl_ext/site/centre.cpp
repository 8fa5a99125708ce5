#include "site/centre.h"

#include <pcl_ext/compression/frame_description.h>

#include "console/exit_status.h"
#include "console/throw_unless_ok.h"
#include "inputs/stream_metadata.h"
#include "streams/stream_decoder.h"

#include <algorithm>
#include <sstream>
#include <utility>

namespace pcl_ext {
namespace tools {

namespace {

io::DecoderLimits
decoderLimits(const CentreOptions& options)
{
  return options.decoding.limits.value_or(nodes::CentralNodeSettings().decoder_limits);
}

nodes::CentralNodeSettings
nodeSettings(const CentreOptions& options, double resolution)
{
  nodes::CentralNodeSettings settings;
  settings.resolution = resolution;
  settings.decoder_limits = decoderLimits(options);
  // Merging is by the times of the clouds; by the clock only for streams with another one.
  settings.max_merge_age =
      options.is_replay ? nodes::Time(1) : options.schedule.max_age;
  return settings;
}

nodes::FrameListener
requestingListener(const Centre::RequestIFrame& request_i_frame)
{
  return [request_i_frame](const nodes::ReceivedFrame& frame) {
    if (frame.wants_i_frame)
      request_i_frame(frame.stream);
  };
}

} // namespace

Centre::Grid::Grid(const CentreOptions& options,
                   double resolution,
                   const RequestIFrame& request_i_frame,
                   Console& console)
: node(nodeSettings(options, resolution), requestingListener(request_i_frame))
, encoder(resolution, options.stream)
, map(options.map, resolution, console)
{
  if (!node.settingsStatus().ok())
    throw UsageError(node.settingsStatus().message());
}

Centre::Centre(const CentreOptions& options,
               RequestIFrame request_i_frame,
               Console& console)
: options_(options)
, request_i_frame_(std::move(request_i_frame))
, console_(console)
, schedule_(options.schedule)
{
  if (const std::string fault = faultOf(options.schedule); !fault.empty())
    throw UsageError(fault);
  // Without a resolution for what is wrong with the others.
  makeGrid(options.resolution.value_or(nodes::CentralNodeSettings().resolution));
  if (!options.resolution)
    grid_.reset();
}

void
Centre::makeGrid(double resolution)
{
  auto grid = std::make_unique<Grid>(options_, resolution, request_i_frame_, console_);
  const std::lock_guard<std::mutex> lock(grid_mutex_);
  grid_ = std::move(grid);
}

std::vector<nodes::StreamHealth>
Centre::health() const
{
  const std::lock_guard<std::mutex> lock(grid_mutex_);
  return grid_ ? grid_->node.health() : std::vector<nodes::StreamHealth>();
}

void
Centre::addOutput(LiveOutput& output)
{
  outputs_.push_back({&output, output.addStream(options_.name, {})});
}

bool
Centre::addStream(const link::LinkFrame& frame)
{
  const auto added = grid_->node.addStream(
      frame.stream, options_.decoding.min_intensity.value_or(0.0f));
  if (!added.ok()) {
    console_.error(frame.stream + ": it is left out: " + added.message());
    return false;
  }
  if (options_.decoding.removes_outliers) {
    VoxelOutlierRemovalSettings removal =
        outlierRemovalOf(options_.decoding, frame.metadata);
    const auto law = lawOf(frame.metadata);
    if (removal.unit == DensityUnit::Automatic && law)
      removal.unit = densityUnitOf(*law);
    if (const auto set = grid_->node.setOutlierRemoval(frame.stream, removal);
        !set.ok())
      console_.error(frame.stream + ": its outliers stay: " + set.message());
  }
  grid_->map.addStream(frame.stream, frame.metadata);
  return true;
}

void
Centre::take(const link::LinkFrame& frame)
{
  if (!grid_) {
    // The first frame that comes is an I-frame.
    const io::FrameDescription first = io::describeFrame(
        frame.bytes.data(), frame.bytes.size(), decoderLimits(options_));
    if (!first.status.ok())
      return;
    std::ostringstream remark;
    remark << "voxels have the edge of those of " << frame.stream << ", "
           << first.grid.resolution << " m; --resolution sets another";
    console_.remark(remark.str());
    makeGrid(first.grid.resolution);
  }
  latest_time_ = std::max(latest_time_, frame.time);
  auto found = streams_.find(frame.stream);
  if (found == streams_.end())
    found = streams_.emplace(frame.stream, addStream(frame)).first;
  if (found->second)
    schedule_.add({frame.stream, frame.time, frame.bytes}, now());
}

void
Centre::work()
{
  if (!grid_)
    return;
  nodes::MergeSchedule::Step step;
  do {
    step = schedule_.next(now());
    for (nodes::ScheduledFrame& frame : step.frames) {
      const auto status =
          grid_->node.receive(frame.stream, std::move(frame.bytes), frame.stamp);
      // A stream that is too fast for this machine is in the statistics.
      if (!status.ok() && status.code() != nodes::CentralNodeCode::TooManyWaiting)
        throwUnlessOk(status);
    }
    if (step.merge)
      merge(*step.merge);
  }
  while (step.merge);
}

void
Centre::merge(nodes::Time time)
{
  grid_->node.waitUntilDecoded();
  grid_->map.update(grid_->node, time);
  if (outputs_.empty())
    return;
  const nodes::MergeStatus status = grid_->node.merge(
      merged_, nodes::StampRange{time - options_.schedule.max_age, time});
  throwUnlessOk(status);
  for (const nodes::MergedStream& stream : status.streams)
    if (!stream.frame)
      ++missing_[stream.name];
  if (wants_i_frame_.exchange(false))
    grid_->encoder.requestIFrame();
  std::vector<std::uint8_t> bytes;
  throwUnlessOk(grid_->encoder.encode(merged_, time, "", bytes));
  for (const Output& output : outputs_)
    output.output->publish(output.stream, time, bytes);
  ++merged_frames_;
}

void
Centre::finish()
{
  if (!grid_)
    return;
  if (options_.is_replay) {
    // What is held for streams that have ended.
    latest_time_ += options_.schedule.max_wait;
    work();
  }
  grid_->node.waitUntilDecoded();
  grid_->map.finish(grid_->node);
}

} // namespace tools
} // namespace pcl_ext
