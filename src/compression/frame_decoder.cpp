#include <pcl_ext/compression/frame_decoder.h>

#include "byte_source.h"
#include "memory_buffer.h"
#include "payload_coder.h"
#include "published_frame.h"
#include "version1_header.h"

#include <algorithm>
#include <array>
#include <new>
#include <utility>

namespace pcl_ext {
namespace io {

namespace {

enum class FoundFormat { None, Version1, Published };

/** \brief Reads until one of the two magic words has passed.
 * \param[in,out] source where to read
 * \param[in,out] last_bytes what was read last, the newest byte lowest; a search that
 * was cut off goes on with it
 */
FoundFormat
findFrame(ByteSource& source, std::uint64_t& last_bytes)
{
  const auto word = [](const char* text, std::size_t size) {
    std::uint64_t bytes = 0;
    for (std::size_t i = 0; i < size; ++i)
      bytes = bytes << 8 | static_cast<std::uint8_t>(text[i]);
    return bytes;
  };
  const std::uint64_t version1 = word(version1_magic, version1_magic_size);
  const std::uint64_t published = word(published_magic, published_magic_size);
  const auto mask = [](std::size_t size) {
    return (std::uint64_t{1} << (8 * size)) - 1;
  };
  for (;;) {
    const std::uint8_t byte = source.u8();
    if (source.failure() != ByteSource::Failure::None)
      return FoundFormat::None;
    last_bytes = last_bytes << 8 | byte;
    if ((last_bytes & mask(version1_magic_size)) == version1)
      return FoundFormat::Version1;
    if ((last_bytes & mask(published_magic_size)) == published)
      return FoundFormat::Published;
  }
}

} // namespace

class FrameDecoder::Implementation {
public:
  explicit Implementation(const DecoderLimits& limits) : limits_(limits) {}

  CompressionStatus
  decode(std::streambuf& buffer, VoxelFrame& frame)
  {
    CompressionStatus status;
    // Buffers are other people's code and may throw anything, as may the memory.
    try {
      const std::streambuf::off_type begin = positionOf(buffer);
      std::size_t frame_offset = 0;
      status = decodeNext(buffer, frame, frame_offset);
      if (mayHideFrames(status.code()) ||
          (status.code() == CompressionCode::MissingReference &&
           !continuesWithFrame(buffer)))
        seekTo(buffer, begin, frame_offset + 1);
    }
    catch (const std::bad_alloc&) {
      status = {CompressionCode::InputFailed, "out of memory while decoding a frame"};
    }
    catch (const std::exception& exception) {
      status = {CompressionCode::InputFailed,
                std::string("reading failed: ") + exception.what()};
    }
    catch (...) {
      status = {CompressionCode::InputFailed, "reading failed"};
    }
    if (!status.ok()) {
      frame.keys.clear();
      frame.intensities.clear();
    }
    return status;
  }

  const std::optional<FrameStamp>&
  stamp() const
  {
    return stamp_;
  }

  const CodedFrameStatistics&
  statistics() const
  {
    return statistics_;
  }

private:
  /** \brief True if a frame or nothing follows, so that the size of the one before, which
   * nobody could check, was right. Buffers that cannot seek are believed. */
  static bool
  continuesWithFrame(std::streambuf& buffer)
  {
    const std::streambuf::off_type position = positionOf(buffer);
    if (position < 0)
      return true;
    std::array<char, published_magic_size> next{};
    const std::streamsize size = buffer.sgetn(next.data(), next.size());
    seekTo(buffer, position, 0);
    const auto begins = [&](const char* magic, std::size_t magic_size) {
      const auto known = std::min(static_cast<std::size_t>(size), magic_size);
      return std::equal(magic, magic + known, next.data());
    };
    return begins(version1_magic, version1_magic_size) ||
           begins(published_magic, published_magic_size);
  }

  /** \brief True if a forged size may have made the failed frame swallow others, which
   * the next call shall find. A frame that merely lacks its reference has been read whole
   * if another one follows it.
   */
  static bool
  mayHideFrames(CompressionCode code)
  {
    return code != CompressionCode::Ok && code != CompressionCode::EndOfStream &&
           code != CompressionCode::NoFrame &&
           code != CompressionCode::MissingReference;
  }

  /** \brief Read position of a buffer; -1 if it cannot seek, which some say by
   * throwing.
   */
  static std::streambuf::off_type
  positionOf(std::streambuf& buffer)
  {
    try {
      return buffer.pubseekoff(0, std::ios_base::cur, std::ios_base::in);
    }
    catch (...) {
      return -1;
    }
  }

  static void
  seekTo(std::streambuf& buffer, std::streambuf::off_type begin, std::size_t offset)
  {
    if (begin < 0)
      return;
    try {
      buffer.pubseekpos(begin + static_cast<std::streambuf::off_type>(offset),
                        std::ios_base::in);
    }
    catch (...) {
      // The bytes are lost, as those of a buffer that cannot seek; the status stands.
    }
  }

  CompressionStatus
  decodeNext(std::streambuf& buffer, VoxelFrame& frame, std::size_t& frame_offset)
  {
    ByteSource search(buffer, limits_.max_frame_bytes);
    std::uint64_t last_bytes = std::exchange(unfinished_search_, 0);
    const FoundFormat format = findFrame(search, last_bytes);
    if (format == FoundFormat::None) {
      if (search.failure() == ByteSource::Failure::LimitExceeded)
        unfinished_search_ = last_bytes;
      return noFrame(search);
    }
    const std::size_t magic_size =
        format == FoundFormat::Version1 ? version1_magic_size : published_magic_size;
    // A magic word that the search before this one had begun to read has no offset
    // here.
    frame_offset = search.consumed() - std::min(search.consumed(), magic_size);

    CodedFrameStatistics statistics;
    statistics.skipped_bytes = frame_offset;
    ByteSource source(buffer,
                      limits_.max_frame_bytes -
                          std::min(limits_.max_frame_bytes, magic_size));
    const CompressionStatus status =
        format == FoundFormat::Version1
            ? decodeVersion1(source, frame, statistics)
            : decodePublished(source, limits_, published_, frame, statistics);
    if (!status.ok())
      return status;
    statistics.voxels = frame.size();
    statistics.bytes = magic_size + source.consumed();
    statistics_ = statistics;
    if (format == FoundFormat::Published)
      stamp_.reset();
    return status;
  }

  CompressionStatus
  noFrame(const ByteSource& search) const
  {
    if (search.failure() == ByteSource::Failure::LimitExceeded)
      return {CompressionCode::NoFrame,
              "no frame begins within the limit of " +
                  std::to_string(limits_.max_frame_bytes) + " bytes"};
    if (search.consumed() == 0)
      return {CompressionCode::EndOfStream, "the stream holds no bytes"};
    return {CompressionCode::NoFrame,
            "no frame begins in the last " + std::to_string(search.consumed()) +
                " bytes of the stream"};
  }

  CompressionStatus
  decodeVersion1(ByteSource& source,
                 VoxelFrame& frame,
                 CodedFrameStatistics& statistics)
  {
    Version1Header& header = header_;
    std::uint32_t checksum = 0;
    if (CompressionStatus status =
            readVersion1Header(source, limits_, header, checksum, checked_bytes_);
        !status.ok())
      return status;
    const std::size_t header_size = checked_bytes_.size();
    const auto payload_size = static_cast<std::size_t>(header.payload_size);
    source.read(payload_size, checked_bytes_);
    if (source.failure() == ByteSource::Failure::LimitExceeded)
      return {CompressionCode::LimitExceeded, "a frame larger than the limit on bytes"};
    if (source.failure() == ByteSource::Failure::EndOfInput)
      return {CompressionCode::Truncated, "the stream ends in a frame's payload"};
    if (!header.is_i_frame && !followsHistory(header))
      return {CompressionCode::MissingReference,
              "P-frame " + std::to_string(header.frame_number) +
                  " depends on the frame before it; " +
                  (has_history_ ? "the last one decoded is frame " +
                                      std::to_string(frame_number_)
                                : "none has been decoded")};
    if (version1Checksum(header.is_i_frame ? 0 : checksum_,
                         checked_bytes_.data(),
                         checked_bytes_.size()) != checksum)
      return {CompressionCode::Corrupt,
              "frame " + std::to_string(header.frame_number) +
                  " contradicts its checksum"};

    PayloadSizes sizes;
    if (CompressionStatus status =
            decodePayload(header, checked_bytes_.data() + header_size, frame, sizes);
        !status.ok())
      return status;
    statistics.frame_number = header.frame_number;
    statistics.is_i_frame = header.is_i_frame;
    statistics.occupancy_bytes = sizes.occupancy;
    statistics.intensity_bytes = payload_size - sizes.occupancy;
    statistics.header_bytes = version1_magic_size + source.consumed() - payload_size;
    commit(header, checksum, frame);
    return {};
  }

  /** \brief True if a P-frame is the successor of what was decoded last. */
  bool
  followsHistory(const Version1Header& header) const
  {
    return has_history_ && header.frame_number - 1 == frame_number_;
  }

  CompressionStatus
  decodePayload(const Version1Header& header,
                const std::uint8_t* payload,
                VoxelFrame& frame,
                PayloadSizes& sizes)
  {
    const std::uint8_t* const end = payload + header.payload_size;
    frame.grid = header.is_i_frame ? header.grid : grid_;
    frame.intensity_scale =
        header.is_i_frame ? header.intensity_scale : intensity_scale_;
    frame.depth_model = header.is_i_frame ? std::nullopt : depth_model_;
    if (!header.is_i_frame && header.effort != effort_)
      return {CompressionCode::Corrupt,
              "frame header: a P-frame of another coder than its I-frame"};
    if (header.has_depth_model) {
      if (!header.is_i_frame && !depth_model_)
        return {CompressionCode::Corrupt,
                "frame header: a depth model that the I-frame does not have"};
      if (!readDepthModel(payload, frame.depth_model.emplace()))
        return {CompressionCode::Corrupt, "the depth model is none"};
      payload += depth_model_size;
    }
    if (!header.is_i_frame &&
        coders_.of(effort_).recordCount() > maxRecords(limits_.max_voxels))
      return {CompressionCode::LimitExceeded,
              "the stream's history is larger than the limit on voxels allows"};
    if (!coders_.of(header.effort)
             .decode(payload,
                     end,
                     static_cast<std::size_t>(header.voxel_count),
                     header.is_i_frame,
                     frame,
                     sizes))
      return {CompressionCode::Corrupt,
              "the payload is not " + std::to_string(header.voxel_count) + " voxels"};
    return {};
  }

  void
  commit(const Version1Header& header, std::uint32_t checksum, const VoxelFrame& frame)
  {
    if (header.has_frame_id || header.is_i_frame)
      frame_id_ = header.frame_id;
    if (header.is_i_frame)
      last_stamp_ = 0;
    if (header.stamp) {
      last_stamp_ += static_cast<std::uint64_t>(*header.stamp);
      if (!stamp_)
        stamp_.emplace();
      stamp_->stamp = last_stamp_;
      stamp_->frame_id = frame_id_;
    }
    else
      stamp_.reset();
    has_history_ = true;
    frame_number_ = header.frame_number;
    checksum_ = checksum;
    effort_ = header.effort;
    grid_ = frame.grid;
    intensity_scale_ = frame.intensity_scale;
    depth_model_ = frame.depth_model;
  }

  DecoderLimits limits_;
  std::uint64_t unfinished_search_ = 0; // last bytes of a search that the limit cut off
  CodedFrameStatistics statistics_;
  std::optional<FrameStamp> stamp_;

  PublishedHistory published_;

  // Of version 1: the frames that were decoded.
  bool has_history_ = false;
  std::uint32_t frame_number_ = 0;
  std::uint32_t checksum_ = 0;
  VoxelGrid grid_;
  IntensityScale intensity_scale_;
  Effort effort_ = Effort::Balanced;
  std::optional<DepthModel> depth_model_;
  std::string frame_id_;
  std::uint64_t last_stamp_ = 0;
  PayloadCoders coders_;
  // Of the current frame; members so that their memory is reused.
  Version1Header header_;
  std::vector<std::uint8_t> checked_bytes_;
};

FrameDecoder::FrameDecoder(const DecoderLimits& limits)
: implementation_(std::make_unique<Implementation>(limits))
{}

FrameDecoder::~FrameDecoder() = default;
FrameDecoder::FrameDecoder(FrameDecoder&&) noexcept = default;
FrameDecoder&
FrameDecoder::operator=(FrameDecoder&&) noexcept = default;

CompressionStatus
FrameDecoder::decode(std::streambuf& source, VoxelFrame& frame)
{
  return implementation_->decode(source, frame);
}

CompressionStatus
FrameDecoder::decode(const std::uint8_t* bytes, std::size_t size, VoxelFrame& frame)
{
  MemoryBuffer buffer(bytes, size);
  return implementation_->decode(buffer, frame);
}

const std::optional<FrameStamp>&
FrameDecoder::stamp() const
{
  return implementation_->stamp();
}

const CodedFrameStatistics&
FrameDecoder::statistics() const
{
  return implementation_->statistics();
}

} // namespace io
} // namespace pcl_ext
