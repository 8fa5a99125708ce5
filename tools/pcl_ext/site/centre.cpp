#include "site/centre.h"

#include "console/exit_status.h"
#include "console/throw_unless_ok.h"
#include "inputs/stream_metadata.h"
#include "streams/stream_decoder.h"

#include <utility>

namespace pcl_ext {
namespace tools {

namespace {

nodes::CentralNodeSettings
nodeSettings(const CentreOptions& options)
{
  nodes::CentralNodeSettings settings;
  settings.resolution = options.resolution;
  settings.decoder_limits =
      options.decoding.limits.value_or(nodes::CentralNodeSettings().decoder_limits);
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

Centre::Centre(const CentreOptions& options,
               RequestIFrame request_i_frame,
               Console& console)
: options_(options)
, request_i_frame_(std::move(request_i_frame))
, console_(console)
, node_(nodeSettings(options), requestingListener(request_i_frame_))
, schedule_(options.schedule)
, encoder_(options.resolution, options.stream)
, map_(options.map, options.resolution, console)
{
  if (!node_.settingsStatus().ok())
    throw UsageError(node_.settingsStatus().message());
  if (const std::string fault = faultOf(options.schedule); !fault.empty())
    throw UsageError(fault);
}

void
Centre::addOutput(LiveOutput& output)
{
  outputs_.push_back({&output, output.addStream(options_.name, {})});
}

bool
Centre::addStream(const link::LinkFrame& frame)
{
  const auto added =
      node_.addStream(frame.stream, options_.decoding.min_intensity.value_or(0.0f));
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
    if (const auto set = node_.setOutlierRemoval(frame.stream, removal); !set.ok())
      console_.error(frame.stream + ": its outliers stay: " + set.message());
  }
  map_.addStream(frame.stream, frame.metadata);
  return true;
}

void
Centre::take(const link::LinkFrame& frame)
{
  auto found = streams_.find(frame.stream);
  if (found == streams_.end())
    found = streams_.emplace(frame.stream, addStream(frame)).first;
  if (found->second)
    schedule_.add({frame.stream, frame.time, frame.bytes}, nodes::steadyTime());
}

void
Centre::work()
{
  nodes::MergeSchedule::Step step;
  do {
    step = schedule_.next(nodes::steadyTime());
    for (nodes::ScheduledFrame& frame : step.frames) {
      const auto status =
          node_.receive(frame.stream, std::move(frame.bytes), frame.stamp);
      // A stream that is too fast for this machine is in the statistics.
      if (!status.ok() && status.code() != nodes::CentralNodeCode::TooManyWaiting)
        throwUnlessOk(status);
    }
    if (step.merge)
      merge(*step.merge);
  }
  while (step.merge);
  map_.work();
}

void
Centre::merge(nodes::Time time)
{
  node_.waitUntilDecoded();
  map_.update(node_);
  if (outputs_.empty())
    return;
  throwUnlessOk(node_.merge(merged_));
  if (wants_i_frame_.exchange(false))
    encoder_.requestIFrame();
  std::vector<std::uint8_t> bytes;
  throwUnlessOk(encoder_.encode(merged_, time, "", bytes));
  for (const Output& output : outputs_)
    output.output->publish(output.stream, time, bytes);
  ++merged_frames_;
}

void
Centre::finish()
{
  node_.waitUntilDecoded();
  map_.finish();
}

} // namespace tools
} // namespace pcl_ext
