// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// A project without PCL: frames -> a page in the browser.
#include <pcl_ext/compression/frame_encoder.h>
#include <pcl_ext/view/view_server.h>

#include <chrono>
#include <cstdint>
#include <iostream>
#include <optional>
#include <vector>

int
main()
{
  using namespace pcl_ext;
  view::ViewServerSettings settings;
  settings.page = "<!doctype html>";
  view::ViewServer server(settings);
  std::size_t stream = 0;
  view::ViewServerStatus status = server.start();
  if (status.ok())
    status = server.addStream("/sensor", {}, stream);
  io::VoxelFrame frame;
  frame.grid.resolution = 0.1;
  frame.grid.depth = 4;
  frame.intensity_scale.bits = 8;
  frame.keys = {1, 7, 100};
  frame.intensities = {10, 20, 30};
  io::FrameEncoder encoder(io::StreamFormat::Version1, 30);
  std::vector<std::uint8_t> bytes;
  encoder.encode(frame, std::nullopt, bytes);
  if (status.ok())
    status = server.publish(stream, std::chrono::seconds(1), bytes);
  std::cout << server.url() << ' ' << status << '\n';
  return status.ok() && server.statistics().frames == 1 ? 0 : 1;
}
