// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * Fuzz target: a file of any bytes is read as a recording, frame by frame and in any
 * order, in bounded time and memory.
 *
 * The first byte chooses what is done; the others are the file.
 */
#include <pcl_ext/recording/recording_reader.h>

#include "checked_decoding.h"
#include "recording/bag_reader.h"
#include "recording/point_cloud_messages.h"

#include <sys/mman.h>
#include <unistd.h>

#include <string>

namespace {

using namespace pcl_ext::recording;

class MemoryFile {
public:
  MemoryFile(const std::uint8_t* bytes, std::size_t size)
  : descriptor_(::memfd_create("recording", 0))
  {
    pcl_ext::fuzz::require(descriptor_ >= 0);
    pcl_ext::fuzz::require(::write(descriptor_, bytes, size) ==
                           static_cast<ssize_t>(size));
  }

  ~MemoryFile() { ::close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile&
  operator=(const MemoryFile&) = delete;

  std::string
  path() const
  {
    return "/proc/self/fd/" + std::to_string(descriptor_);
  }

private:
  int descriptor_;
};

void
readMessages(const std::string& path)
{
  BagReader reader;
  if (!reader.open(path).ok())
    return;
  McapMessage message;
  PointCloudMessage cloud;
  Time last = Time::min();
  for (const BagEntry& entry : reader.index()) {
    pcl_ext::fuzz::require(entry.log_time >= last);
    pcl_ext::fuzz::require(entry.channel < reader.channels().size());
    last = entry.log_time;
    const RecordingStatus status = reader.read(entry, message);
    pcl_ext::fuzz::require(status.ok() || !reader.damage().empty());
    for (const bool is_compressed : {false, true})
      for (const MessageEncoding encoding :
           {MessageEncoding::Cdr, MessageEncoding::Ros1})
        readPointCloud(
            message.bytes.data(), message.bytes.size(), is_compressed, cloud, encoding);
  }
  std::vector<McapMetadata> metadata;
  reader.readMetadata(metadata);
  reader.readAttachments([](const McapAttachment&) { return RecordingStatus(); });
}

void
readFrames(const std::string& path, bool in_order)
{
  RecordingReader reader;
  if (!reader.open(path).ok())
    return;
  pcl_ext::io::VoxelFrame voxels;
  RecordedFrame frame;
  std::vector<RecordedStreamDecoder> decoders;
  for (std::size_t i = 0; i < reader.streams().size(); ++i)
    decoders.emplace_back(reader, i, pcl_ext::fuzz::smallLimits());
  if (in_order) {
    while (reader.next(frame).code() != RecordingCode::EndOfRecording)
      decoders[frame.stream].decode(frame, voxels);
    return;
  }
  // Every third frame from the end on, a few at most, as each needs those before it.
  for (std::size_t i = 0; i < decoders.size(); ++i)
    for (std::size_t back = 1; back < 20 && back <= reader.streams()[i].frames;
         back += 3)
      decoders[i].decode(reader.streams()[i].frames - back, voxels);
}

} // namespace

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  if (size == 0)
    return 0;
  const MemoryFile file(data + 1, size - 1);
  if (data[0] % 3 == 0)
    readMessages(file.path());
  else
    readFrames(file.path(), data[0] % 3 == 1);
  return 0;
}
