// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/impl/cloud_streams.h>

#include <pcl/console/print.h>

#include <exception>
#include <fstream>
#include <istream>
#include <ostream>
#include <string>

namespace pcl_ext {
namespace io {
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

CompressionStatus
readFrame(std::istream& input, FrameDecoder& decoder, VoxelFrame& frame)
{
  if (CompressionStatus status = checkInput(input); !status.ok())
    return status;
  CompressionStatus status = decoder.decode(*input.rdbuf(), frame);
  if (status.code() == CompressionCode::EndOfStream ||
      status.code() == CompressionCode::NoFrame) {
    try {
      input.setstate(std::ios_base::eofbit | std::ios_base::failbit);
    }
    catch (const std::exception&) {
      // An input that is set to throw; the bits are set nevertheless.
    }
  }
  return status;
}

} // namespace

CloudStreams::CloudStreams(const IntensityCompressionSettings& settings,
                           const std::optional<DepthLaw>& model_law,
                           IntensityUnit unit)
: settings_(settings)
, limits_status_(checkLimits(settings.decoder_limits))
, settings_status_(checkSettings(settings))
, encoder_(settings, unit, model_law ? model_law : settings.depth_law)
, decoder_(settings.decoder_limits, settings.incomplete_frame)
{}

void
CloudStreams::setResolution(double resolution, const std::optional<DepthLaw>& model_law)
{
  settings_.resolution = resolution;
  settings_status_ = checkSettings(settings_);
  encoder_.setResolution(resolution, model_law ? model_law : settings_.depth_law);
}

CompressionStatus
CloudStreams::checkEncoding(bool has_cloud) const
{
  if (!settings_status_.ok())
    return settings_status_;
  if (!encoder_.settingsStatus().ok())
    return encoder_.settingsStatus();
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
  info_.sensor_pose = sensor_pose.cast<double>();
  info_.time.reset();
  if (header.stamp != 0)
    info_.time = timeOfStamp(header.stamp);
  if (settings_.carry_header) {
    if (!info_.stamp)
      info_.stamp.emplace();
    info_.stamp->stamp = header.stamp;
    info_.stamp->frame_id = header.frame_id;
  }
  has_encoded_ = true;
  CompressionStatus status = encoder_.encode(source, info_, bytes);
  if (!status.ok())
    return status;
  statistics_ = encoder_.statistics();
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
  if (printed_warnings_.insert(words).second)
    PCL_WARN("[pcl_ext::io::OctreePointCloudIntensityCompression] %s\n",
             status.message().c_str());
}

CompressionStatus
CloudStreams::decode(std::istream& input)
{
  if (!limits_status_.ok())
    return limits_status_;
  has_encoded_ = false;
  return finishDecoding(readFrame(input, decoder_, frame_));
}

CompressionStatus
CloudStreams::decode(const std::uint8_t* bytes, std::size_t size)
{
  if (!limits_status_.ok())
    return limits_status_;
  has_encoded_ = false;
  return finishDecoding(decoder_.decode(bytes, size, frame_));
}

CompressionStatus
CloudStreams::finishDecoding(CompressionStatus status)
{
  if (status.ok())
    statistics_ = {VoxelizationStatistics(), decoder_.statistics()};
  return status;
}

void
CloudStreams::copyStampTo(pcl::PCLHeader& header) const
{
  if (!decoder_.stamp())
    return;
  header.stamp = decoder_.stamp()->stamp;
  header.frame_id = decoder_.stamp()->frame_id;
}

void
CloudStreams::showStatistics(const char* title) const
{
  if (!settings_.show_statistics)
    return;
  const CodedFrameStatistics& coding = statistics_.coding;
  PCL_INFO("*** POINTCLOUD %s ***\n", title);
  PCL_INFO("Frame ID: %u\n", coding.frame_number);
  PCL_INFO("Frame type: %s\n", coding.is_i_frame ? "Intra frame" : "Prediction frame");
  if (statistics_.voxelization.points > 0) {
    const VoxelizationStatistics& voxelization = statistics_.voxelization;
    PCL_INFO("Number of points: %zu, of these not finite: %zu, outside the box: %zu, "
             "outside the grid: %zu\n",
             voxelization.points,
             voxelization.points_not_finite,
             voxelization.points_outside_box,
             voxelization.points_outside_grid);
    PCL_INFO("Compression ratio to 16 bytes a point: %.2f\n",
             statistics_.compressionRatio());
  }
  PCL_INFO("Number of voxels: %zu\n", coding.voxels);
  PCL_INFO("Size of compressed frame: %zu bytes (header %zu, occupancy %zu, intensity "
           "%zu, attributes %zu)\n",
           coding.bytes,
           coding.header_bytes,
           coding.occupancy_bytes,
           coding.intensity_bytes,
           coding.attribute_bytes);
  PCL_INFO("Bytes per voxel: %.3f\n\n", statistics_.bytesPerVoxel());
}

} // namespace detail
} // namespace io
} // namespace pcl_ext
