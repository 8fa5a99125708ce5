// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/frame_decoder.h>

#include "bytes/byte_source.h"
#include "bytes/exceptions.h"
#include "codec/frame_order.h"
#include "codec/memory_share.h"
#include "codec/payload_coder.h"
#include "codec/published/frame.h"
#include "stream/frame_search.h"
#include "stream/latest_voxels.h"
#include "stream/version1_decoder.h"
#include "voxels/memory_rule.h"
#include "voxels/point_voxels.h"

#include <algorithm>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {

class FrameDecoder::Implementation {
public:
  Implementation(const DecoderLimits& limits, IncompleteFrame incomplete_frame)
  : limits_(limits)
  , search_(limits.max_frame_bytes, incomplete_frame == IncompleteFrame::Keep)
  , version1_(limits)
  , share_(limits.budget, [this] { dropHistory(); })
  {}

  /** \brief Decodes a frame.
   * \param[out] frame its voxels, unless only changes are asked for
   * \param[out] changes null if they are not asked for
   */
  CompressionStatus
  decode(std::streambuf& buffer,
         VoxelFrame& frame,
         VoxelChanges* changes,
         CodingWorkspace& work)
  {
    share_.begin();
    search_.begin(buffer);
    found_ = FoundFormat::None;
    size_ = 0;
    are_listed_ = false;
    skipped_ = 0;
    const auto input_failed = [](const std::string& reason) {
      return CompressionStatus(CompressionCode::InputFailed,
                               "reading failed: " + reason);
    };
    // The caller's buffer may throw, too.
    CompressionStatus status =
        callOrElse([&] { return decodeNext(buffer, frame, changes, work); },
                   outOfMemoryStatus<CompressionStatus>,
                   input_failed);
    search_.end(status, buffer, skipped_);
    if (!status.ok())
      frame.clearVoxels();
    followStream(status, frame, work);
    share_.end(memoryBytes());
    return status;
  }

  CompressionStatus
  decode(std::streambuf& buffer, VoxelChanges& changes, CodingWorkspace& work)
  {
    tells_changes_ = true;
    const CompressionStatus status = decode(buffer, latest_.decoded(), &changes, work);
    if (!status.ok()) {
      changes.gone.clearVoxels();
      changes.came.clearVoxels();
      changes.is_from_nothing = false;
    }
    return status;
  }

  bool
  latestVoxels(VoxelFrame& frame)
  {
    share_.begin();
    const auto list = [&] {
      if (latest_.areKept())
        frame = latest_.kept();
      else if (areInCoder(last_found_))
        version1_.listLastVoxels(frame);
      else
        return false;
      return true;
    };
    const bool are_known = callOrElse(list, [] { return false; });
    if (!are_known)
      frame.clearVoxels();
    share_.end(memoryBytes());
    return are_known;
  }

  /** \brief Scratch memory for callers that pass none. */
  CodingWorkspace&
  ownWorkspace()
  {
    return own_workspace_;
  }

  void
  setDecodesVoxels(bool decodes_voxels)
  {
    decodes_voxels_ = decodes_voxels;
  }

  const std::optional<FrameStamp>&
  stamp() const
  {
    static const std::optional<FrameStamp> none;
    return last_found_ == FoundFormat::Published ? none : version1_.stamp();
  }

  const CodedFrameStatistics&
  statistics() const
  {
    return statistics_;
  }

private:
  CompressionStatus
  decodeNext(std::streambuf& buffer,
             VoxelFrame& frame,
             VoxelChanges* changes,
             CodingWorkspace& work)
  {
    CompressionStatus status;
    found_ = search_.find(buffer, status);
    if (found_ == FoundFormat::None)
      return status;
    const std::size_t magic_size = magicSize(found_);
    CodedFrameStatistics statistics;
    statistics.skipped_bytes = search_.frameOffset();
    ByteSource source(buffer,
                      limits_.max_frame_bytes -
                          std::min(limits_.max_frame_bytes, magic_size));
    status = found_ == FoundFormat::Published
                 ? decodePublished(source, frame, changes, statistics)
                 : decodeVersion1(source, work, frame, changes, statistics);
    skipped_ = source.skipped();
    if (!status.ok())
      return status;
    if (!are_listed_)
      status = setFrame(frame, changes, statistics);
    statistics.bytes = magic_size + source.consumed();
    statistics_ = statistics;
    return status;
  }

  CompressionStatus
  decodePublished(ByteSource& source,
                  VoxelFrame& frame,
                  const VoxelChanges* changes,
                  CodedFrameStatistics& statistics)
  {
    if (changes != nullptr)
      keepLatest();
    frame.layout.reset();
    return published::decodeFrame(
        source, limits_, published_, published_order_, frame, statistics);
  }

  CompressionStatus
  decodeVersion1(ByteSource& source,
                 CodingWorkspace& work,
                 VoxelFrame& frame,
                 VoxelChanges* changes,
                 CodedFrameStatistics& statistics)
  {
    if (CompressionStatus status = version1_.read(source); !status.ok())
      return status;
    if (changes == nullptr || !version1_.isOfChanges() || !areInCoder(last_found_)) {
      if (changes != nullptr)
        keepLatest();
      return version1_.decode(work, frame, statistics);
    }
    CompressionStatus status = version1_.decodeChanges(work, *changes, statistics);
    if (status.ok()) {
      are_listed_ = true;
      size_ = statistics.voxels;
      changes->is_from_nothing = false;
      latest_.leaveToCoder();
    }
    return status;
  }

  /** \brief Whether the coder of frames of changes knows the last frame.
   * \param[in] format of this frame
   */
  bool
  areInCoder(FoundFormat format) const
  {
    return format == FoundFormat::Version1 && version1_.knowsLastVoxels();
  }

  /** \brief Keeps the voxels of the last frame, which the coder of frames of changes is
   * about to lose. */
  void
  keepLatest()
  {
    if (!latest_.areKept() && areInCoder(last_found_))
      latest_.keep([this](VoxelFrame& frame) { version1_.listLastVoxels(frame); });
  }

  /** \brief Sets the voxels of a decoded frame if it has its points, and what differs
   * from the last frame.
   * \return Ok, with a warning if points were left out
   */
  CompressionStatus
  setFrame(VoxelFrame& frame, VoxelChanges* changes, CodedFrameStatistics& statistics)
  {
    const auto set = [&] {
      if (decodes_voxels_ || changes != nullptr)
        setVoxels(frame);
      statistics.voxels = frame.points.areThere() ? frame.pointCount() : frame.size();
      size_ = frame.size() + frame.fieldValueCount() + frame.points.cloudSize();
      CompressionStatus status = statusOfVoxels(frame);
      if (changes != nullptr)
        latest_.keepDecoded(*changes);
      else if (tells_changes_ && areInCoder(found_))
        latest_.leaveToCoder();
      else if (tells_changes_)
        // Without memory for a copy the next changes are from nothing.
        callOrElse([&] { latest_.keepCopy(frame); }, [this] { latest_.drop(); });
      return status;
    };
    return callOrCleanUp(set, [&] {
      latest_.drop();
      // The next frame refers to this one, which the caller does not get.
      if (changes != nullptr)
        version1_.forget();
    });
  }

  /** \brief Releases memory that recent frames did not need, and the history of a
   * format that the stream no longer has. */
  void
  followStream(const CompressionStatus& status,
               VoxelFrame& frame,
               CodingWorkspace& work)
  {
    if (status.code() == CompressionCode::EndOfStream) {
      version1_.inputEnded();
      published_order_.inputEnded();
    }
    if (status.ok()) {
      frames_in_a_row_ = found_ == last_found_ ? frames_in_a_row_ + 1 : 1;
      last_found_ = found_;
    }
    if (frames_in_a_row_ == MemoryRule::frames) {
      if (last_found_ == FoundFormat::Published)
        version1_.forget();
      else
        published_ = published::History();
    }
    std::size_t needed = size_;
    if (status.ok())
      needed += statistics_.bytes;
    std::size_t taken = needed;
    if (found_ == FoundFormat::Version1) {
      needed += version1_.trackedVoxels();
      taken = version1_.memoryTaken();
    }
    work.endFrame(needed, taken);
    if (memory_rule_.shouldRelease(needed, taken))
      releaseMemory(frame);
  }

  /** \brief Bytes that are kept, an estimate that is rather too high. */
  std::size_t
  memoryBytes() const
  {
    const std::size_t of_voxel =
        own_workspace_.isUsed() ? kept_bytes_with_workspace : kept_bytes_of_voxel;
    return of_voxel * memory_rule_.most() + version1_.memoryBytes() +
           latest_.memoryBytes();
  }

  /** \brief Drops what is kept of earlier frames, as the memory is needed elsewhere. */
  void
  dropHistory() noexcept
  {
    version1_.drop();
    published_ = published::History();
    own_workspace_.releaseMemory();
    latest_.drop();
    memory_rule_ = MemoryRule();
  }

  void
  releaseMemory(VoxelFrame& frame)
  {
    const auto release = [&] {
      version1_.releaseMemory();
      releaseExcess(frame);
      latest_.releaseMemory();
    };
    // Without memory for smaller copies the memory stays as it is.
    callOrElse(release, [] {});
  }

  DecoderLimits limits_;
  bool decodes_voxels_ = true;
  bool tells_changes_ = false; // a caller has asked for them
  FrameSearch search_;
  CodedFrameStatistics statistics_;
  FoundFormat last_found_ = FoundFormat::None; // of the last decoded frame
  std::size_t frames_in_a_row_ = 0;            // of this format
  // Of the current call.
  FoundFormat found_ = FoundFormat::None;
  std::size_t skipped_ = 0;
  std::size_t size_ = 0;    // voxels, points and values of fields
  bool are_listed_ = false; // the changes, without the whole frame
  Version1Decoder version1_;
  published::History published_;
  LatestVoxels latest_;
  FrameOrder published_order_{false};
  CodingWorkspace own_workspace_;
  MemoryRule memory_rule_;
  MemoryShare share_; // the last member, as its destructor ends the use of the others
};

DecodingMemory::DecodingMemory() : workspace_(std::make_unique<CodingWorkspace>()) {}
DecodingMemory::~DecodingMemory() = default;
DecodingMemory::DecodingMemory(DecodingMemory&&) noexcept = default;
DecodingMemory&
DecodingMemory::operator=(DecodingMemory&&) noexcept = default;

FrameDecoder::FrameDecoder(const DecoderLimits& limits,
                           IncompleteFrame incomplete_frame)
: implementation_(std::make_unique<Implementation>(limits, incomplete_frame))
{}

FrameDecoder::~FrameDecoder() = default;
FrameDecoder::FrameDecoder(FrameDecoder&&) noexcept = default;
FrameDecoder&
FrameDecoder::operator=(FrameDecoder&&) noexcept = default;

CompressionStatus
FrameDecoder::decode(std::streambuf& source, VoxelFrame& frame)
{
  return implementation_->decode(
      source, frame, nullptr, implementation_->ownWorkspace());
}

CompressionStatus
FrameDecoder::decode(const std::uint8_t* bytes, std::size_t size, VoxelFrame& frame)
{
  MemoryBuffer buffer(bytes, size);
  return implementation_->decode(
      buffer, frame, nullptr, implementation_->ownWorkspace());
}

CompressionStatus
FrameDecoder::decode(const std::uint8_t* bytes,
                     std::size_t size,
                     VoxelFrame& frame,
                     DecodingMemory& memory)
{
  MemoryBuffer buffer(bytes, size);
  return implementation_->decode(buffer, frame, nullptr, *memory.workspace_);
}

CompressionStatus
FrameDecoder::decode(const std::uint8_t* bytes, std::size_t size, VoxelChanges& changes)
{
  MemoryBuffer buffer(bytes, size);
  return implementation_->decode(buffer, changes, implementation_->ownWorkspace());
}

CompressionStatus
FrameDecoder::decode(const std::uint8_t* bytes,
                     std::size_t size,
                     VoxelChanges& changes,
                     DecodingMemory& memory)
{
  MemoryBuffer buffer(bytes, size);
  return implementation_->decode(buffer, changes, *memory.workspace_);
}

bool
FrameDecoder::latestVoxels(VoxelFrame& frame)
{
  return implementation_->latestVoxels(frame);
}

void
FrameDecoder::setDecodesVoxels(bool decodes_voxels)
{
  implementation_->setDecodesVoxels(decodes_voxels);
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

} // namespace pcl_ext::PCL_EXT_ABI::io
