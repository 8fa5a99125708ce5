// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// A project without PCL: points -> a page in the browser.
#include <pcl_ext/compression/cloud_encoder.h>
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
  const std::vector<float> points{0.01f, 0.2f, 0.3f, 1.0f, 1.1f, 1.2f};
  io::PointView points_view;
  points_view.coordinates = points.data();
  points_view.coordinate_stride = 3 * sizeof(float);
  points_view.count = 2;
  io::CloudEncoder encoder(io::EncoderSettings(), IntensityUnit::Points);
  std::vector<std::uint8_t> bytes;
  encoder.encode(points_view, {}, bytes);
  if (status.ok())
    status = server.publish(stream, std::chrono::seconds(1), bytes);
  std::cout << server.url() << ' ' << status << '\n';
  return status.ok() && server.statistics().frames == 1 ? 0 : 1;
}
