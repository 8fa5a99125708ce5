// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What the native codec makes of a stream, for comparison with WebAssembly.
 *
 *     reference dump FILE UNIT    writes all frames, and the noise in them
 *     reference time FILE         prints milliseconds of the processor a frame
 *     reference encode COUNTS     points -> a frame with fields of them, or if COUNTS
 *                                 is 0 of voxels of 1 m
 *
 * A frame is: number of voxels, whether there are intensities, colours, numbers of
 * points (std::uint32_t each), then for all voxels x, y, z (float), intensity (float),
 * red, green, blue (std::uint8_t), number of points (std::uint32_t), and whether a
 * VoxelOutlierRemoval removes the voxel (std::uint8_t; 2: it judged none). A point is a
 * TestPoint.
 */
#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iostream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext;
using Bytes = std::vector<std::uint8_t>;

struct Centres {
  std::vector<float> positions;
  std::vector<float> intensities;
};

void
computeCentres(const io::VoxelFrame& frame, Centres& centres)
{
  centres.positions.resize(3 * frame.size());
  centres.intensities.resize(frame.size());
  std::size_t i = 0;
  io::forEachVoxelCentre(frame, [&](float x, float y, float z, float intensity) {
    centres.positions[3 * i] = x;
    centres.positions[3 * i + 1] = y;
    centres.positions[3 * i + 2] = z;
    centres.intensities[i++] = intensity;
  });
}

template <typename T>
void
write(const T* values, std::size_t count)
{
  std::cout.write(reinterpret_cast<const char*>(values),
                  static_cast<std::streamsize>(count * sizeof(T)));
}

/** \brief 1 for the voxels that the filter removes. */
Bytes
noiseOf(const io::VoxelFrame& frame, VoxelOutlierRemoval& filter)
{
  io::VoxelFrame kept = frame;
  if (!filter.filter(kept).ok())
    return Bytes(frame.size(), 2);
  Bytes noise;
  for (const std::uint64_t key : frame.keys)
    noise.push_back(std::binary_search(kept.keys.begin(), kept.keys.end(), key) ? 0
                                                                                : 1);
  return noise;
}

void
writeFrame(const io::VoxelFrame& frame, VoxelOutlierRemoval& filter)
{
  const std::uint32_t head[] = {static_cast<std::uint32_t>(frame.size()),
                                frame.hasIntensities() ? 1u : 0u,
                                frame.colour_bits > 0 ? 1u : 0u,
                                frame.has_point_counts ? 1u : 0u};
  write(head, 4);
  Centres centres;
  computeCentres(frame, centres);
  write(centres.positions.data(), centres.positions.size());
  if (frame.hasIntensities())
    write(centres.intensities.data(), centres.intensities.size());
  if (frame.colour_bits > 0)
    for (std::size_t i = 0; i < frame.size(); ++i) {
      const io::VoxelColour colour = frame.fullColour(i);
      const std::uint8_t channels[] = {colour.r, colour.g, colour.b};
      write(channels, 3);
    }
  if (frame.has_point_counts)
    write(frame.point_counts.data(), frame.size());
  const Bytes noise = noiseOf(frame, filter);
  write(noise.data(), noise.size());
}

void
exitUnlessOk(const io::CompressionStatus& status)
{
  if (status.ok())
    return;
  std::cerr << status.message() << '\n';
  std::exit(1);
}

/** \brief Calls a function with each frame of a stream that is decoded; ends the
 * program if one is not. */
template <typename VisitT>
void
decodeAll(const Bytes& bytes, VisitT visit)
{
  io::FrameDecoder decoder;
  io::VoxelFrame frame;
  for (std::size_t at = 0; at < bytes.size(); at += decoder.statistics().bytes) {
    const auto status = decoder.decode(bytes.data() + at, bytes.size() - at, frame);
    exitUnlessOk(status);
    visit(frame);
  }
}

void
printTime(const Bytes& bytes)
{
  Centres centres;
  std::size_t frames = 0;
  double milliseconds = 0.0;
  for (int round = 0; round < 3; ++round) { // the last one counts
    frames = 0;
    const std::clock_t begin = std::clock();
    decodeAll(bytes, [&](const io::VoxelFrame& frame) {
      computeCentres(frame, centres);
      ++frames;
    });
    milliseconds = 1000.0 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  }
  std::cout << milliseconds / static_cast<double>(frames) << '\n';
}

struct TestPoint {
  float position[3];
  std::int32_t label;
  double time;
  float normal[2];
};

/** \brief Writes the frame of the points that it reads. */
void
encodePoints(bool has_counts)
{
  const Bytes bytes{std::istreambuf_iterator<char>(std::cin), {}};
  std::vector<TestPoint> points(bytes.size() / sizeof(TestPoint));
  std::memcpy(points.data(), bytes.data(), points.size() * sizeof(TestPoint));
  io::EncoderSettings settings;
  settings.resolution = 1.0;
  settings.keep_points = has_counts;
  settings.fields = {{io::all_fields}};
  io::PointView view;
  view.count = points.size();
  view.coordinates = points.front().position;
  view.coordinate_stride = sizeof(TestPoint);
  const auto add =
      [&](const char* name, io::FieldType type, unsigned count, const void* first) {
        io::FieldDescription description;
        description.name = name;
        description.type = type;
        description.count = count;
        view.fields.push_back({description, first, sizeof(TestPoint)});
      };
  add("label", io::FieldType::Int32, 1, &points.front().label);
  add("time", io::FieldType::Float64, 1, &points.front().time);
  add("normal", io::FieldType::Float32, 2, points.front().normal);
  io::CloudEncoder encoder(settings, IntensityUnit::None);
  Bytes encoded;
  exitUnlessOk(encoder.encode(view, {}, encoded));
  write(encoded.data(), encoded.size());
}

} // namespace

int
main(int argc, char** argv)
{
  if (argc < 3)
    return 2;
  if (std::strcmp(argv[1], "encode") == 0) {
    encodePoints(std::atoi(argv[2]) != 0);
    return 0;
  }
  std::ifstream file(argv[2], std::ios::binary);
  const Bytes bytes{std::istreambuf_iterator<char>(file), {}};
  if (std::strcmp(argv[1], "time") == 0) {
    printTime(bytes);
    return 0;
  }
  const auto unit = static_cast<DensityUnit>(argc > 3 ? std::atoi(argv[3]) : 0);
  VoxelOutlierRemoval filter({densityUnitSettings(unit)});
  decodeAll(bytes, [&](const io::VoxelFrame& frame) { writeFrame(frame, filter); });
  return 0;
}
