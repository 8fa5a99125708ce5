// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// A project without PCL: points -> a recording -> voxels.
#include <pcl_ext/compression/cloud_encoder.h>
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
  const std::vector<float> points{0.01f, 0.2f, 0.3f, 1.0f, 1.1f, 1.2f};
  io::PointView view;
  view.coordinates = points.data();
  view.coordinate_stride = 3 * sizeof(float);
  view.count = 2;
  io::CloudEncoder encoder(io::EncoderSettings(), IntensityUnit::Points);
  std::vector<std::uint8_t> bytes;
  recording::RecordingWriter writer;
  std::size_t stream = 0;
  recording::RecordingStatus status = writer.open("consumer.mcap");
  if (status.ok())
    status = writer.addStream({"/sensor", "world", {}}, stream);
  for (int second = 1; second <= 10 && status.ok(); ++second) {
    encoder.encode(view, {}, bytes);
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
  return is_decoded && decoded.keys == encoder.frame().keys ? 0 : 1;
}
