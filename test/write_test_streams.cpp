// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Writes the files that test_golden_streams and test_invalid_files read.
 *
 *     write_test_streams golden test/data/golden
 *     write_test_streams invalid test/data/invalid
 *
 * Golden streams are written once for a version of the bitstream: writing other ones
 * changes the bitstream.
 */
#include "support/forged_frames.h"
#include "support/golden_streams.h"
#include "support/scan_frames.h"

#include <algorithm>
#include <fstream>
#include <iostream>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

bool
write(const std::string& path, const Bytes& bytes)
{
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  return file.good();
}

bool
writeGoldenStreams(const std::string& folder)
{
  std::ofstream checksums(folder + "/checksums.txt");
  bool is_good = true;
  for (const GoldenStream& stream : goldenStreams()) {
    const SentStream sent_stream = sent(stream);
    for (const std::size_t index : sent_stream.decoded)
      checksums << stream.name << (sent_stream.are_i_frames[index] ? " I " : " P ")
                << lineOf(stream.frames[index]) << '\n';
    is_good = is_good && write(folder + '/' + stream.name + ".pcxi", sent_stream.bytes);
  }
  return is_good && checksums.good();
}

/** \brief A frame with another number at some bytes; its checksum is right again. */
Bytes
changed(Bytes frame, std::size_t at, const Bytes& bytes)
{
  std::copy(
      bytes.begin(), bytes.end(), frame.begin() + static_cast<std::ptrdiff_t>(at));
  return withChecksum(frame);
}

Bytes
withDepthModel(Parts parts, const DepthModel& model)
{
  Bytes payload;
  writeDepthModel(model, payload);
  append(parts.payload, payload);
  parts.payload = payload;
  parts.header.has_depth_model = true;
  return putTogetherSized(parts);
}

Bytes
payloadOf(const VoxelFrame& frame)
{
  FrameEncoder encoder(StreamFormat::Version1, 1, Effort::Balanced);
  Bytes bytes = encoded(encoder, frame);
  // Without the padding of frames with so many points, which is bytes of 0.
  while (bytes.back() == 0)
    bytes.pop_back();
  return {bytes.begin() +
              static_cast<std::ptrdiff_t>(encoder.statistics().header_bytes),
          bytes.end()};
}

/** \brief Two voxels whose points are 19 modulo 2^32, as the header says, and a field of
 * 60001 points. */
Bytes
withPointsThatOverflow()
{
  VoxelFrame voxels = emptyFrame(5);
  voxels.keys = {3, 77};
  voxels.intensities = {1, 2};
  voxels.has_point_counts = true;
  voxels.point_counts = {0xfffffff5u, 30};
  const Bytes of_voxels = payloadOf(voxels);
  voxels.point_counts = {60000, 1};
  voxels.fields = {{{"ring", FieldType::UInt16}, {}}};
  voxels.fields.front().numbers.resize(voxels.pointCount());
  FrameEncoder encoder(StreamFormat::Version1, 1, Effort::Balanced);
  Parts parts = takeApart(encoded(encoder, voxels));
  const auto supplement_size =
      static_cast<std::ptrdiff_t>(parts.header.supplement_size);
  const Bytes supplement(parts.payload.end() - supplement_size, parts.payload.end());
  parts.payload = of_voxels;
  append(supplement, parts.payload);
  parts.header.point_count = 19;
  return putTogetherSized(parts);
}

/** \brief Frames of which each is invalid in one way, by the name of their file. */
std::vector<std::pair<std::string, Bytes>>
invalidFrames()
{
  std::mt19937_64 random(1);
  const VoxelFrame voxels = randomFrame(random, 5, 40);
  FrameEncoder encoder(StreamFormat::Version1, 100, Effort::Balanced);
  const Bytes i_frame = encoded(encoder, voxels);
  const Bytes p_frame = encoded(encoder, voxels);
  const Parts parts = takeApart(i_frame);
  const auto forged = [&](auto change) {
    Parts changed_parts = parts;
    change(changed_parts.header);
    return putTogether(changed_parts);
  };
  using Header = Version1Header;
  const auto withField = [&](auto change) {
    return forged([&](Header& header) {
      header.content.has_fields = true;
      header.fields = {{"ring", FieldType::UInt16}};
      change(header);
    });
  };

  Bytes wrong_checksum = i_frame;
  wrong_checksum[6] = static_cast<std::uint8_t>(wrong_checksum[6] ^ 1u);
  Bytes other_version = i_frame;
  other_version[version1_magic_size] = 2;
  // As many voxels as the limits allow, with a payload of one byte.
  Parts voxels_out_of_nothing = parts;
  voxels_out_of_nothing.header.voxel_count = std::uint64_t{1} << 20;
  voxels_out_of_nothing.header.grid = emptyFrame(21).grid;
  voxels_out_of_nothing.payload = {0};
  // The type, with a step, and the number of values are before the step.
  const auto step_of_256 =
      withField([](Header& header) { header.fields.front().step = 256.0; });
  const Bytes bytes_of_256{0x84, 1, 0, 0, 0, 0, 0, 0, 0x70, 0x40};
  const auto step_place = std::search(
      step_of_256.begin(), step_of_256.end(), bytes_of_256.begin(), bytes_of_256.end());
  const Bytes no_field_step =
      changed(step_of_256,
              static_cast<std::size_t>(step_place - step_of_256.begin()) + 8,
              {0, 0});
  // The content is before the resolution; 0x80 0x02 are fields, 0x80 0x04 a scan, 0x80
  // 0x08 a placement, 0x80 0x40 what is not known.
  const auto withContent = [&](std::uint8_t high) {
    return changed(withField([](Header&) {}), flags_offset + 1 + 4, {0x80, high});
  };
  const auto withLayout = [&](std::size_t fields, std::uint32_t point_step) {
    MessageLayout layout;
    PlacedField field;
    field.name = "x";
    field.offset = 12;
    layout.fields.resize(fields, field);
    layout.point_step = point_step;
    return withField([&](Header& header) {
      header.layout = std::make_shared<MessageLayout>(layout);
    });
  };
  // More points than the header has.
  VoxelFrame points = voxels;
  addPointCounts(random, points);
  points.fields = {{{"ring", FieldType::UInt16}, {}}};
  points.fields.front().numbers.resize(points.pointCount());
  FrameEncoder point_encoder(StreamFormat::Version1, 100, Effort::Balanced);
  Parts parts_with_points = takeApart(encoded(point_encoder, points));
  parts_with_points.header.point_count = points.size();
  const Bytes points_of_fields = putTogether(parts_with_points);
  DepthModel cubes;
  cubes.exponent = 3;
  DepthModel far_away;
  far_away.origin = (std::int64_t{1} << 56) + 1;
  Parts cut_off = parts;
  cut_off.header.has_depth_model = true;
  cut_off.payload.resize(depth_model_size - 1);

  scan::ScanFrame scan = makeLidar();
  fireOddRowsFirst(scan);
  addPoints(scan, 1);
  FrameEncoder scan_encoder(StreamFormat::Version1, 100, Effort::Balanced);
  const Parts parts_with_scan = takeApart(encoded(scan_encoder, scan));
  const auto withScan = [&](auto change) {
    Parts changed_parts = parts_with_scan;
    change(changed_parts.header.scan);
    return putTogether(changed_parts);
  };
  using scan::ScanLayout;

  return {
      {"ends_in_header", Bytes(i_frame.begin(), i_frame.begin() + 20)},
      {"ends_in_payload", Bytes(i_frame.begin(), i_frame.end() - 3)},
      {"wrong_checksum", wrong_checksum},
      {"unknown_version", other_version},
      {"unknown_coder", changed(i_frame, flags_offset, {0x31})},
      {"p_frame_alone", p_frame},
      {"too_many_voxels",
       forged([](Header& header) { header.voxel_count = std::uint64_t{1} << 40; })},
      {"voxels_without_end",
       forged([](Header& header) { header.voxel_count = ~std::uint64_t{0}; })},
      {"too_many_bytes",
       forged([](Header& header) { header.payload_size = std::uint64_t{1} << 40; })},
      {"bytes_that_do_not_come",
       forged([](Header& header) { header.payload_size = std::uint64_t{1} << 23; })},
      {"voxels_out_of_nothing", putTogetherSized(voxels_out_of_nothing)},
      {"payload_without_voxels",
       forged([](Header& header) { header.voxel_count = 0; })},
      {"depth_model_of_cubes", withDepthModel(parts, cubes)},
      {"depth_model_far_away", withDepthModel(parts, far_away)},
      {"depth_model_cut_off", putTogetherSized(cut_off)},
      {"grid_too_deep", forged([](Header& header) { header.grid.depth = 22; })},
      {"grid_off_the_lattice",
       forged([](Header& header) { header.grid.first_index[2] = 1 << 20; })},
      {"symbols_of_17_bits",
       forged([](Header& header) { header.intensity_scale.bits = 17; })},
      {"long_frame_id", forged([](Header& header) {
         header.has_frame_id = true;
         header.frame_id = std::string(1025, 'x');
       })},
      {"placement_of_an_i_frame", withContent(0x08)},
      {"unknown_content", withContent(0x40)},
      {"scan_without_point_counts", withContent(0x04)},
      {"layout_beyond_the_point", withLayout(1, 15)},
      {"too_many_fields_of_a_layout", withLayout(2000, 16)},
      {"no_fields", withField([](Header& header) { header.fields.clear(); })},
      {"too_many_fields", withField([](Header& header) {
         header.fields.resize(most_fields + 1, header.fields.front());
       })},
      {"field_without_name",
       withField([](Header& header) { header.fields.front().name.clear(); })},
      {"long_field_name", withField([](Header& header) {
         header.fields.front().name = std::string(most_field_name_bytes + 1, 'x');
       })},
      {"unknown_field_type", withField([](Header& header) {
         header.fields.front().type = static_cast<FieldType>(9);
       })},
      {"field_without_values",
       withField([](Header& header) { header.fields.front().count = 0; })},
      {"too_many_field_values", withField([](Header& header) {
         header.fields.resize(2, header.fields.front());
         header.fields.front().count = most_field_values;
       })},
      {"negative_field_step",
       withField([](Header& header) { header.fields.front().step = -1.0; })},
      {"no_field_step", no_field_step},
      {"viewpoint_far_away", withField([](Header& header) {
         header.viewpoint[1] = -farthest_viewpoint - 1;
       })},
      {"fields_without_supplement", withField([](Header&) {})},
      {"points_of_fields_without_end", points_of_fields},
      {"points_of_fields_that_overflow", withPointsThatOverflow()},
      {"scan_without_columns", withScan([](ScanLayout& s) { s.width = 0; })},
      {"too_many_pixels",
       withScan([](ScanLayout& s) { s.width = s.height = 1 << 13; })},
      {"scan_too_steep", withScan([](ScanLayout& s) { s.rays.rows[0].run = 1 << 30; })},
      {"scan_with_rows_twice",
       withScan([](ScanLayout& s) { s.firing_order[0] = s.firing_order[1]; })},
      {"scan_with_other_rows", withScan([](ScanLayout& s) { --s.height; })},
      {"scan_moved_out", withScan([](ScanLayout& s) {
         s.row_shifts.assign(s.height, 0);
         s.row_shifts[1] = static_cast<std::uint16_t>(s.width);
       })},
      {"scan_of_unknown_rays",
       withScan([](ScanLayout& s) { s.rays.shape = static_cast<scan::RayShape>(3); })},
      {"half_depths_of_no_camera",
       withScan([](ScanLayout& s) { s.rays.has_half_depths = true; })}};
}

bool
writeInvalidStreams(const std::string& folder)
{
  bool is_good = true;
  for (const auto& [name, bytes] : invalidFrames())
    is_good = write(folder + '/' + name + ".pcxi", bytes) && is_good;
  return is_good;
}

} // namespace

int
main(int argc, char** argv)
{
  const std::string what = argc == 3 ? argv[1] : "";
  const bool is_good = what == "golden"    ? writeGoldenStreams(argv[2])
                       : what == "invalid" ? writeInvalidStreams(argv[2])
                                           : false;
  if (!is_good)
    std::cerr << "write_test_streams golden|invalid FOLDER: the folder must be there\n";
  return is_good ? 0 : 1;
}
