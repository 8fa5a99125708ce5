/** \file
 * \brief Writes the files that test_golden_streams and test_invalid_files read.
 *
 *     write_test_streams golden test/data/golden
 *     write_test_streams invalid test/data/invalid
 *
 * Golden streams are written once, when stream version 1 is frozen; whoever writes them
 * again has changed the bitstream.
 */
#include "support/forged_frames.h"
#include "support/golden_streams.h"

#include <fstream>
#include <iomanip>
#include <iostream>
#include <random>
#include <string>

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
    FrameEncoder encoder(StreamFormat::Version1, stream.i_frame_rate, stream.effort);
    Bytes bytes;
    for (const GoldenFrame& frame : stream.frames) {
      append(encoded(encoder, frame.frame, frame.stamp), bytes);
      checksums << stream.name << (encoder.statistics().is_i_frame ? " I " : " P ")
                << std::dec << frame.frame.size() << ' ' << std::hex << std::setw(16)
                << std::setfill('0') << VoxelChecksum(frame.frame).value() << std::dec
                << ' ' << (frame.stamp ? std::to_string(frame.stamp->stamp) : "-")
                << '\n';
    }
    is_good = is_good && write(folder + '/' + stream.name + ".pcxi", bytes);
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

bool
writeInvalidStreams(const std::string& folder)
{
  std::mt19937_64 random(1);
  VoxelFrame voxels = randomFrame(random, 5, 40);
  FrameEncoder encoder(StreamFormat::Version1, 100);
  const Bytes i_frame = encoded(encoder, voxels);
  const Bytes p_frame = encoded(encoder, voxels);
  const Parts parts = takeApart(i_frame);
  const auto lie = [&](auto change) {
    Parts liar = parts;
    change(liar);
    return putTogether(liar);
  };
  const auto path = [&](const char* name) { return folder + '/' + name + ".pcxi"; };
  const Bytes in_header(i_frame.begin(), i_frame.begin() + 20);
  const Bytes in_payload(i_frame.begin(), i_frame.end() - 3);
  Bytes wrong_checksum = i_frame;
  wrong_checksum[6] = static_cast<std::uint8_t>(wrong_checksum[6] ^ 1u);
  Bytes other_version = i_frame;
  other_version[version1_magic_size] = 2;
  DepthModel model;
  model.exponent = 3;
  const auto put_model = [&](Parts& liar) {
    liar.header.has_depth_model = true;
    Bytes payload;
    writeDepthModel(model, payload);
    append(liar.payload, payload);
    liar.payload = payload;
    liar.header.payload_size = payload.size();
  };
  bool is_good = write(path("ends_in_header"), in_header) &&
                 write(path("ends_in_payload"), in_payload) &&
                 write(path("wrong_checksum"), wrong_checksum) &&
                 write(path("unknown_version"), other_version) &&
                 write(path("unknown_coder"), changed(i_frame, flags_offset, {0x31})) &&
                 write(path("p_frame_alone"), p_frame);
  is_good =
      is_good && write(path("too_many_voxels"), lie([](Parts& liar) {
                         liar.header.voxel_count = std::uint64_t{1} << 40;
                       })) &&
      write(path("voxels_without_end"),
            lie([](Parts& liar) { liar.header.voxel_count = ~std::uint64_t{0}; })) &&
      write(path("too_many_bytes"), lie([](Parts& liar) {
              liar.header.payload_size = std::uint64_t{1} << 40;
            })) &&
      write(path("bytes_that_do_not_come"), lie([](Parts& liar) {
              liar.header.payload_size = std::uint64_t{1} << 23;
            })) &&
      write(path("voxels_out_of_nothing"), lie([](Parts& liar) {
              // All that the limits allow, of a payload of one byte.
              liar.header.voxel_count = std::uint64_t{1} << 20;
              liar.header.grid = emptyFrame(21).grid;
              liar.payload = {0};
              liar.header.payload_size = 1;
            })) &&
      write(path("payload_without_voxels"),
            lie([](Parts& liar) { liar.header.voxel_count = 0; })) &&
      write(path("depth_model_of_cubes"), lie(put_model));
  model = DepthModel();
  model.origin = (std::int64_t{1} << 56) + 1;
  is_good =
      is_good && write(path("depth_model_far_away"), lie(put_model)) &&
      write(path("depth_model_cut_off"), lie([](Parts& liar) {
              liar.header.has_depth_model = true;
              liar.payload.resize(depth_model_size - 1);
              liar.header.payload_size = liar.payload.size();
            })) &&
      write(path("grid_too_deep"),
            lie([](Parts& liar) { liar.header.grid.depth = 22; })) &&
      write(path("grid_off_the_lattice"),
            lie([](Parts& liar) { liar.header.grid.first_index[2] = 1 << 20; })) &&
      write(path("symbols_of_17_bits"),
            lie([](Parts& liar) { liar.header.intensity_scale.bits = 17; })) &&
      write(path("long_frame_id"), lie([](Parts& liar) {
              liar.header.has_frame_id = true;
              liar.header.frame_id = std::string(1025, 'x');
            }));
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
