// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "streams/encoded_stream.h"

#include <pcl_ext/filters/lidar_clouds.h>

#include "console/exit_status.h"
#include "console/interruption.h"
#include "inputs/point_cloud_conversions.h"

#include <algorithm>
#include <deque>
#include <stdexcept>
#include <utility>

namespace pcl_ext::tools {

namespace {

using Outcome = CloudInWork::Outcome;

EncodingOptions
optionsOfPart(const EncodingOptions& options,
              std::size_t first_cloud,
              bool is_single_cloud)
{
  EncodingOptions of_part = options;
  if (is_single_cloud)
    of_part.codec().i_frame_rate = 1; // encoders keep nothing for frames after it
  of_part.codec().first_frame_number = static_cast<std::uint32_t>(first_cloud + 1);
  return of_part;
}

void
encode(StreamEncoder& encoder, CloudInWork& work)
{
  const InputCloud& cloud = work.cloud;
  work.sums = EncodedSums();
  try {
    if (!encoder.encode(
            cloud.cloud, cloud.source, work.frame.bytes, cloud.message.log_time)) {
      work.outcome = Outcome::LeftOut;
      work.sums = encoder.lastCloud();
      return;
    }
    encoder.note(Remark::Header, encoder.name(), cloud.remark);
    encoder.note(Remark::Colours, cloud.source, cloud.colour_remark);
    work.sums = encoder.lastCloud();
    work.frame.message.log_time = cloud.message.log_time;
    work.frame.message.publish_time = cloud.message.publish_time;
    work.frame.message.sequence = cloud.message.sequence;
    work.frame.cloud = describeCloud(cloud.cloud, cloud.stamp);
    work.frame.cloud.frame_id = encoder.frameId();
    work.outcome = Outcome::Frame;
  }
  catch (const UsageError& error) {
    work.outcome = Outcome::Refused;
    work.reason = error.what();
  }
  catch (const std::runtime_error& error) {
    work.outcome = Outcome::Failed;
    work.reason = error.what();
  }
  catch (...) {
    work.fault = std::current_exception();
  }
}

} // namespace

/** \brief Clouds that one encoder encodes, one after the other. */
struct EncodedStream::Part {
  Part(const EncodingOptions& all_options,
       const std::string& name,
       std::size_t first_cloud,
       std::shared_ptr<const pcl::PCLPointCloud2> law_cloud_of_stream,
       std::atomic<IntensityLaw>& law_of_stream,
       CloudInput& unread_input)
  : options(optionsOfPart(all_options, first_cloud, unread_input.size() == 1))
  , encoder(options, name, unread_input.isBag())
  , law_cloud(std::move(law_cloud_of_stream))
  , law(law_of_stream)
  , input(unread_input)
  {}

  /** \brief Reads a cloud, encodes it, and drops it again. */
  void
  readAndEncode(CloudInWork& work)
  {
    if (isInterrupted() || is_given_up) {
      work.outcome = Outcome::Unread;
      return;
    }
    try {
      if (!reader)
        reader = input.placeReader();
      reader->read(work.cloud);
    }
    catch (...) {
      work.fault = std::current_exception();
      return;
    }
    if (work.cloud.failure.empty())
      encode(work);
    else {
      work.outcome = Outcome::Failed;
      work.reason = work.cloud.failure;
    }
    work.cloud.cloud = pcl::PCLPointCloud2();
    work.cloud.message.bytes = std::vector<std::uint8_t>();
  }

  void
  encode(CloudInWork& work)
  {
    if (is_given_up) {
      work.outcome = Outcome::LeftOut;
      return;
    }
    if (law_cloud && refusal.empty())
      try {
        encoder.chooseLaw(*law_cloud);
      }
      catch (const UsageError& error) {
        refusal = error.what();
      }
    law_cloud.reset();
    if (refusal.empty())
      tools::encode(encoder, work);
    else
      work.outcome = Outcome::Refused;
    if (work.outcome != Outcome::Refused)
      law = encoder.law();
    else if (refusal.empty())
      refusal = work.reason;
    work.reason = work.outcome == Outcome::Refused ? refusal : work.reason;
  }

  EncodingOptions options;
  StreamEncoder encoder;
  std::shared_ptr<const pcl::PCLPointCloud2> law_cloud; // until the first cloud
  std::atomic<IntensityLaw>& law;
  CloudInput& input;
  std::shared_ptr<PlaceReader> reader; // of unread clouds, if there was one
  std::string refusal;                 // not empty: all clouds are refused
  std::mutex mutex;                    // of the following
  std::deque<std::shared_ptr<CloudInWork>> clouds;
  bool is_working = false; // a task of the crew encodes them
  std::atomic<bool> is_given_up{false};
};

EncodedStream::EncodedStream(const EncodingOptions& options,
                             const std::string& name,
                             Crew& crew,
                             CloudInput& input)
: options_(options)
, name_(name)
, crew_(crew)
, input_(input)
, clouds_in_part_(cloudsInPart(options))
{}

EncodedStream::~EncodedStream()
{
  for (const auto& part : parts_)
    part->is_given_up = true;
  crew_.workUntil([this] {
    return std::none_of(parts_.begin(), parts_.end(), [](const auto& part) {
      const std::lock_guard<std::mutex> lock(part->mutex);
      return part->is_working;
    });
  });
}

std::size_t
EncodedStream::cloudsInPart(const EncodingOptions& options)
{
  const io::EncoderSettings& codec = options.codec();
  const bool is_divided = codec.format == io::StreamFormat::Version1 &&
                          codec.temporal_filter == 0 && codec.max_rate == 0.0 &&
                          codec.max_encode_ms == 0.0 && !options.removesOutliers();
  // Parts begin where there would be an I-frame anyway.
  const std::size_t rate = std::max<std::size_t>(codec.i_frame_rate, 1);
  return is_divided ? (fewest_in_part + rate - 1) / rate * rate : 0;
}

std::vector<std::shared_ptr<CloudInWork>>
EncodedStream::add(std::shared_ptr<CloudInWork> cloud)
{
  InputCloud& content = cloud->cloud;
  if (!first_number_)
    first_number_ = content.number;
  if (!law_cloud_ && content.is_unread) {
    if (!reader_)
      reader_ = input_.placeReader();
    content.colour_scale = colour_scale_;
    reader_->read(content);
    if (content.failure.empty())
      colour_scale_ = content.colour_scale;
  }
  if (content.is_unread)
    content.colour_scale = colour_scale_;
  if (!content.is_unread && !content.failure.empty()) {
    cloud->outcome = content.is_refused ? Outcome::Refused : Outcome::Failed;
    cloud->reason = content.failure;
    cloud->is_done = true;
    return {cloud};
  }
  waiting_.push_back(cloud);
  if (!law_cloud_) {
    if (!hasPoints(content.cloud))
      return {};
    auto without_points = std::make_shared<pcl::PCLPointCloud2>();
    without_points->header = content.cloud.header;
    without_points->fields = content.cloud.fields;
    without_points->point_step = content.cloud.point_step;
    law_cloud_ = without_points;
    is_of_lidar_ = pcl_ext::isOfLidar(content.cloud);
    reader_.reset();
  }
  return addWaiting();
}

std::vector<std::shared_ptr<CloudInWork>>
EncodedStream::addWaiting()
{
  std::vector<std::shared_ptr<CloudInWork>> begun;
  begun.swap(waiting_);
  for (const auto& cloud : begun)
    begin(cloud);
  return begun;
}

/** \brief Gives a cloud to its part. */
void
EncodedStream::begin(const std::shared_ptr<CloudInWork>& cloud)
{
  // By its number in the input: whether a cloud before can be read may not be known yet.
  const std::size_t number = cloud->cloud.number - *first_number_;
  const std::size_t of_part = clouds_in_part_ == 0 ? 0 : number / clouds_in_part_;
  if (of_part >= next_part_) {
    beginPart(of_part * clouds_in_part_);
    next_part_ = of_part + 1;
  }
  const std::shared_ptr<Part>& part = parts_.back();
  {
    const std::lock_guard<std::mutex> lock(part->mutex);
    part->clouds.push_back(cloud);
    if (std::exchange(part->is_working, true))
      return;
  }
  crew_.add([part, &crew = crew_] { encodeNext(part, crew); });
}

void
EncodedStream::beginPart(std::size_t first_cloud)
{
  // Encoders have much memory.
  while (!parts_.empty()) {
    {
      const std::lock_guard<std::mutex> lock(parts_.front()->mutex);
      if (parts_.front()->is_working)
        break;
    }
    add(parts_.front()->encoder);
    parts_.erase(parts_.begin());
  }
  parts_.push_back(
      std::make_shared<Part>(options_, name_, first_cloud, law_cloud_, law_, input_));
}

/** \brief Encodes the next cloud of a part, as a task. */
void
EncodedStream::encodeNext(const std::shared_ptr<Part>& part, Crew& crew)
{
  std::shared_ptr<CloudInWork> cloud;
  {
    const std::lock_guard<std::mutex> lock(part->mutex);
    cloud = std::move(part->clouds.front());
    part->clouds.pop_front();
  }
  if (cloud->cloud.is_unread)
    part->readAndEncode(*cloud);
  else
    part->encode(*cloud);
  {
    const std::lock_guard<std::mutex> lock(part->mutex);
    part->is_working = !part->clouds.empty();
    cloud->is_done = true;
    if (!part->is_working)
      return;
  }
  crew.add([part, &crew] { encodeNext(part, crew); });
}

/** \brief Adds a part to the report, in which the first that has something to say
 * does. */
void
EncodedStream::add(const StreamEncoder& encoder)
{
  const auto takeFirst = [](std::string& text, const std::string& of_part) {
    if (text.empty())
      text = of_part;
  };
  Remarks remarks = encoder.remarks();
  if (report_.sums.encoded_points > 0)
    remarks.erase(Remark::Unit); // of a cloud that is not the first one with points
  report_.remarks.insert(remarks.begin(), remarks.end());
  takeFirst(report_.frame_id_error, encoder.frameIdError());
  report_.is_filter_chosen = options_.codec().temporal_filter == 0;
  takeFirst(report_.why_nothing, encoder.whyNothingWasEncoded());
  report_.sums += encoder.sums();
  if (report_.sums.encoded_points > 0)
    report_.why_nothing.clear();
}

const EncodedStreamReport&
EncodedStream::finish()
{
  for (const auto& part : parts_)
    add(part->encoder);
  parts_.clear();
  return report_;
}

} // namespace pcl_ext::tools
