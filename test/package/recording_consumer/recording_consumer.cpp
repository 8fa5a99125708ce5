// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// A project without PCL: frames -> a recording -> voxels.
#include <pcl_ext/compression/frame_encoder.h>
#include <pcl_ext/recording/recording_reader.h>
#include <pcl_ext/recording/recording_writer.h>

#include <cstdint>
#include <iostream>
#include <optional>
#include <vector>

int
main()
{
  using namespace pcl_ext;
  io::VoxelFrame frame;
  frame.grid.resolution = 0.1;
  frame.grid.depth = 4;
  frame.intensity_scale.bits = 8;
  frame.keys = {1, 7, 100};
  frame.intensities = {10, 20, 30};
  io::FrameEncoder encoder(io::StreamFormat::Version1, 30);
  std::vector<std::uint8_t> bytes;
  recording::RecordingWriter writer;
  std::size_t stream = 0;
  recording::RecordingStatus status = writer.open("consumer.mcap");
  if (status.ok())
    status = writer.addStream({"/sensor", "world", {}}, stream);
  for (int second = 1; second <= 10 && status.ok(); ++second) {
    encoder.encode(frame, std::nullopt, bytes);
    status =
        writer.append(stream, std::chrono::seconds(second), bytes.data(), bytes.size());
  }
  if (status.ok())
    status = writer.finish();

  recording::RecordingReader reader;
  if (status.ok())
    status = reader.open("consumer.mcap");
  std::cout << status << '\n';
  if (!status.ok())
    return 1;
  recording::RecordedStreamDecoder decoder(reader, 0);
  io::VoxelFrame decoded;
  const bool is_decoded = decoder.decode(9, decoded).ok();
  std::cout << decoded.size() << " voxels\n";
  return is_decoded && decoded.keys == frame.keys ? 0 : 1;
}
