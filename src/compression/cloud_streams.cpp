// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/impl/cloud_streams.h>

#include "voxels/point_voxels.h"

#include <pcl/console/print.h>

#include <exception>
#include <fstream>
#include <istream>
#include <ostream>
#include <set>
#include <string>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace detail {

namespace {

/** \brief True for the buffer of a file that is not open, which a new fstream is,
 * too. */
bool
isClosedFile(const std::streambuf* buffer)
{
  const auto* file = dynamic_cast<const std::filebuf*>(buffer);
  return file != nullptr && !file->is_open();
}

CompressionStatus
checkInput(const std::istream& input)
{
  if (input.rdbuf() == nullptr)
    return {CompressionCode::InputFailed, "the input stream has no buffer"};
  if (isClosedFile(input.rdbuf()))
    return {CompressionCode::InputFailed,
            "the input file is not open; check its path and std::ifstream::is_open()"};
  // At its end the stream is asked again, as more bytes may have arrived.
  if (input.bad() || (input.fail() && !input.eof()))
    return {CompressionCode::InputFailed,
            "the input stream had failed before the call; clear() resets it"};
  return {};
}

} // namespace

struct CloudStreams::Members {
  IntensityCompressionSettings settings;
  CompressionStatus limits_status;
  CompressionStatus settings_status;
  CloudEncoder encoder;
  FrameDecoder decoder;
  FrameStatistics statistics = {};
  bool has_encoded = false; // and not decoded last
  // Members so that their memory is reused.
  VoxelFrame frame = {}; // that was decoded
  CloudInfo info = {};   // of the encoded cloud
  std::vector<std::uint8_t> bytes = {};
  std::set<std::string> printed_warnings = {}; // without their numbers
};

CloudStreams::CloudStreams(const IntensityCompressionSettings& settings,
                           const std::optional<DepthLaw>& model_law,
                           IntensityUnit unit)
: members_(
      new Members{settings,
                  checkLimits(settings.decoder_limits),
                  checkSettings(settings),
                  {settings, unit, model_law ? model_law : settings.depth_law},
                  FrameDecoder(settings.decoder_limits, settings.incomplete_frame)})
{
  members_->decoder.setDecodesVoxels(false);
}

CloudStreams::CloudStreams(CloudStreams&&) noexcept = default;
CloudStreams&
CloudStreams::operator=(CloudStreams&&) noexcept = default;
CloudStreams::~CloudStreams() = default;

const IntensityCompressionSettings&
CloudStreams::settings() const
{
  return members_->settings;
}

const FrameStatistics&
CloudStreams::statistics() const
{
  return members_->statistics;
}

const VoxelFrame&
CloudStreams::frame() const
{
  return members_->has_encoded ? members_->encoder.frame() : members_->frame;
}

const VoxelFrame&
CloudStreams::voxelFrame() const
{
  if (!members_->has_encoded)
    setVoxels(members_->frame);
  return frame();
}

void
CloudStreams::setResolution(double resolution, const std::optional<DepthLaw>& model_law)
{
  IntensityCompressionSettings& settings = members_->settings;
  settings.resolution = resolution;
  members_->settings_status = checkSettings(settings);
  members_->encoder.setResolution(resolution,
                                  model_law ? model_law : settings.depth_law);
}

void
CloudStreams::requestIFrame()
{
  members_->encoder.requestIFrame();
}

double
CloudStreams::resolution() const
{
  return members_->encoder.settings().resolution;
}

void
CloudStreams::setMaxRate(double bits_per_second)
{
  members_->encoder.setMaxRate(bits_per_second);
}

RateControlStatus
CloudStreams::rateControlStatus() const
{
  return members_->encoder.rateControlStatus();
}

std::vector<std::uint8_t>&
CloudStreams::bytes()
{
  return members_->bytes;
}

CompressionStatus
CloudStreams::checkEncoding(bool has_cloud) const
{
  if (!members_->settings_status.ok())
    return members_->settings_status;
  if (!members_->encoder.settingsStatus().ok())
    return members_->encoder.settingsStatus();
  if (!has_cloud)
    return {CompressionCode::InvalidInput, "the cloud to encode is a null pointer"};
  return {};
}

CompressionStatus
CloudStreams::checkOutput(const std::ostream& output)
{
  if (isClosedFile(output.rdbuf()))
    return {CompressionCode::OutputFailed,
            "the output file is not open; check its path and std::ofstream::is_open()"};
  if (!output.good())
    return {CompressionCode::OutputFailed,
            "the output stream is in a failed state; clear() resets it"};
  return {};
}

CompressionStatus
CloudStreams::encode(CloudSource& source,
                     const SensorPose& sensor_pose,
                     const pcl::PCLHeader& header,
                     std::vector<std::uint8_t>& bytes)
{
  CloudInfo& info = members_->info;
  info.sensor_pose = sensor_pose.cast<double>();
  info.time.reset();
  if (header.stamp != 0)
    info.time = timeOfStamp(header.stamp);
  if (members_->settings.carry_header) {
    if (!info.stamp)
      info.stamp.emplace();
    info.stamp->stamp = header.stamp;
    info.stamp->frame_id = header.frame_id;
  }
  members_->has_encoded = true;
  CompressionStatus status = members_->encoder.encode(source, info, bytes);
  if (!status.ok())
    return status;
  members_->statistics = members_->encoder.statistics();
  if (status.hasWarning())
    printWarning(status);
  return status;
}

CompressionStatus
CloudStreams::write(const std::vector<std::uint8_t>& bytes, std::ostream& output)
{
  bool is_written = false;
  try {
    output.write(reinterpret_cast<const char*>(bytes.data()),
                 static_cast<std::streamsize>(bytes.size()));
    output.flush();
    is_written = output.good();
  }
  catch (const std::exception&) {
    // An output that is set to throw; the status reports the failure.
  }
  if (is_written)
    return {};
  return {CompressionCode::OutputFailed,
          "writing a frame of " + std::to_string(bytes.size()) +
              " bytes to the output stream failed"};
}

/** \brief Prints warnings whose words were not printed before. */
void
CloudStreams::printWarning(const CompressionStatus& status)
{
  std::string words;
  for (const char c : status.message())
    if (c < '0' || c > '9')
      words += c;
  if (members_->printed_warnings.insert(words).second)
    PCL_WARN("[pcl_ext::io::OctreePointCloudIntensityCompression] %s\n",
             status.message().c_str());
}

CompressionStatus
CloudStreams::decode(std::istream& input)
{
  if (!members_->limits_status.ok())
    return members_->limits_status;
  members_->has_encoded = false;
  if (CompressionStatus status = checkInput(input); !status.ok())
    return status;
  CompressionStatus status = members_->decoder.decode(*input.rdbuf(), members_->frame);
  std::ios_base::iostate state = std::ios_base::goodbit;
  if (status.code() == CompressionCode::EndOfStream ||
      status.code() == CompressionCode::NoFrame)
    state = std::ios_base::eofbit | std::ios_base::failbit;
  else if (status.code() == CompressionCode::InputFailed)
    state = std::ios_base::badbit;
  if (state != std::ios_base::goodbit) {
    try {
      input.setstate(state);
    }
    catch (const std::exception&) {
      // An input that is set to throw; the bits are set nevertheless.
    }
  }
  return finishDecoding(std::move(status));
}

CompressionStatus
CloudStreams::decode(const std::uint8_t* bytes, std::size_t size)
{
  if (!members_->limits_status.ok())
    return members_->limits_status;
  members_->has_encoded = false;
  return finishDecoding(members_->decoder.decode(bytes, size, members_->frame));
}

CompressionStatus
CloudStreams::finishDecoding(CompressionStatus status)
{
  if (status.ok())
    members_->statistics = {VoxelizationStatistics(), members_->decoder.statistics()};
  return status;
}

void
CloudStreams::copyStampTo(pcl::PCLHeader& header) const
{
  if (!members_->decoder.stamp())
    return;
  header.stamp = members_->decoder.stamp()->stamp;
  header.frame_id = members_->decoder.stamp()->frame_id;
}

void
CloudStreams::showStatistics(const char* title) const
{
  if (!members_->settings.show_statistics)
    return;
  const CodedFrameStatistics& coding = members_->statistics.coding;
  PCL_INFO("*** POINTCLOUD %s ***\n", title);
  PCL_INFO("Frame ID: %u\n", coding.frame_number);
  PCL_INFO("Frame type: %s\n", coding.is_i_frame ? "Intra frame" : "Prediction frame");
  if (members_->statistics.voxelization.points > 0) {
    const VoxelizationStatistics& voxelization = members_->statistics.voxelization;
    PCL_INFO("Number of points: %zu, of these not finite: %zu, outside the box: %zu, "
             "outside the grid: %zu\n",
             voxelization.points,
             voxelization.points_not_finite,
             voxelization.points_outside_box,
             voxelization.points_outside_grid);
    PCL_INFO("Compression ratio to 16 bytes a point: %.2f\n",
             members_->statistics.compressionRatio());
  }
  const char* const unit = coding.has_points ? "point" : "voxel";
  PCL_INFO("Number of %ss: %zu\n", unit, coding.voxels);
  if (coding.has_points)
    PCL_INFO("Size of compressed frame: %zu bytes (header %zu, points %zu)\n",
             coding.bytes,
             coding.header_bytes,
             coding.bytes - coding.header_bytes);
  else
    PCL_INFO(
        "Size of compressed frame: %zu bytes (header %zu, occupancy %zu, intensity "
        "%zu, attributes %zu)\n",
        coding.bytes,
        coding.header_bytes,
        coding.occupancy_bytes,
        coding.intensity_bytes,
        coding.attribute_bytes);
  PCL_INFO("Bytes per %s: %.3f\n\n", unit, members_->statistics.bytesPerVoxel());
}

} // namespace detail
} // namespace pcl_ext::PCL_EXT_ABI::io
