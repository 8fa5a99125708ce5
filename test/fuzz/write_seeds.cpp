/** \file
 * \brief Writes inputs for the fuzz targets to begin with, a folder for each target.
 *
 *     write_seeds TEST_DATA FOLDER
 *
 * Targets that read streams get the golden and the invalid ones of TEST_DATA, cut into
 * parts that targets can hold, and short streams of all kinds. Of what other targets read,
 * a few inputs are made that get far into them.
 */
#include "frame_row.h"
#include "small_streams.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <string>

namespace {

using namespace pcl_ext::fuzz;
using pcl_ext::io::test::append;

class SeedWriter {
public:
  explicit SeedWriter(const std::filesystem::path& folder) : folder_(folder) {}

  void
  write(const std::string& target, const std::string& name, const Bytes& bytes)
  {
    std::filesystem::create_directories(folder_ / target);
    std::ofstream file(folder_ / target / name, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    is_good_ = is_good_ && file.flush().good();
  }

  bool
  isGood() const
  {
    return is_good_;
  }

private:
  std::filesystem::path folder_;
  bool is_good_ = true;
};

/** \brief A stream in parts, of which each begins with an I-frame and none is larger than
 * what mutates well. */
void
writeParts(const std::string& name,
           const Bytes& stream,
           std::size_t most_parts,
           SeedWriter& writer)
{
  constexpr std::size_t most_bytes = 1000;
  const FrameRow row(stream.data(), stream.size());
  Bytes part;
  std::size_t parts = 0;
  const auto end_part = [&] {
    if (part.empty() || parts == most_parts)
      return;
    const std::string part_name = name + '_' + std::to_string(parts++);
    writer.write("frames", part_name, part);
    writer.write("decode_any_bytes", part_name, part);
    part.clear();
  };
  for (const RowFrame& frame : row.frames) {
    const bool stands_alone = !frame.isVersion1() || frame.isIFrame();
    if (stands_alone && part.size() + frame.bytes.size() > most_bytes)
      end_part();
    // P-frames that have no room any more are left out, and so are those behind them.
    if (stands_alone || part.size() + frame.bytes.size() <= most_bytes)
      append(frame.bytes, part);
  }
  end_part();
}

void
writeFiles(const std::filesystem::path& folder, SeedWriter& writer)
{
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".pcxi")
      continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const std::vector<char> content{std::istreambuf_iterator<char>(file), {}};
    const std::string name = entry.path().stem().string();
    // Effort Small takes most time, and differs little from Balanced.
    writeParts(name,
               {content.begin(), content.end()},
               name.compare(0, 5, "small") == 0 ? 1 : 100,
               writer);
  }
}

void
writeSmallStreams(SeedWriter& writer)
{
  for (std::uint8_t kind = 0; kind < stream_choices; ++kind) {
    SentStream stream;
    sendAll(streamKind(kind),
            sensorFrames(streamKind(kind), kind + 1u, 10, 0.04),
            4,
            1,
            stream);
    Bytes bytes;
    for (const SentFrame& frame : stream.frames)
      append(frame.bytes, bytes);
    writeParts("small_stream_" + std::to_string(kind), bytes, 100, writer);
  }
}

/** \brief Inputs of targets whose bytes are choices. */
void
writeChoices(SeedWriter& writer)
{
  std::mt19937 random(1);
  for (std::uint8_t kind = 0; kind < stream_choices; ++kind) {
    const std::string name = "kind_" + std::to_string(kind);
    // Frames in order; one lost, a copy; two senders in turn.
    writer.write("sequences", name + "_in_order", {kind, 0, 0, 0, 0, 0, 0, 0});
    writer.write("sequences", name + "_loss", {kind, 0, 0, 2, 0, 0, 3, 1, 0, 0, 0});
    writer.write("sequences", name + "_turns", {kind, 0, 0, 8, 0, 8, 7, 0, 0, 8, 0});
    writer.write(
        "sequences", name + "_damage", {kind, 0, 0, 5, 99, 0, 0, 6, 20, 0, 4, 3, 0, 0});
    for (std::uint8_t mode = 0; mode < 5; ++mode)
      for (const unsigned int allocations : {0u, 3u, 20u, 60u, 150u}) {
        Bytes bytes{static_cast<std::uint8_t>(16 * mode + kind),
                    1,
                    static_cast<std::uint8_t>(allocations)};
        for (std::size_t i = 0; i < 4; ++i)
          append({0, 3, static_cast<std::uint8_t>(allocations / 4)}, bytes);
        writer.write("failing_memory",
                     name + '_' + std::to_string(mode) + '_' +
                         std::to_string(allocations),
                     bytes);
      }
  }
  for (unsigned int kind = 0; kind < 64; ++kind) {
    // Choices, settings, size and kind of a layout, and numbers for what these ask for.
    Bytes bytes{static_cast<std::uint8_t>(kind % 16),
                static_cast<std::uint8_t>(kind / 4),
                static_cast<std::uint8_t>(0x24 + 8 * (kind % 3)),
                static_cast<std::uint8_t>(kind + kind / 16 * 64)};
    for (std::size_t i = 0; i < 40; ++i)
      bytes.push_back(static_cast<std::uint8_t>(random() % 200));
    writer.write("cloud_layouts", "layout_" + std::to_string(kind), bytes);
    Bytes points{static_cast<std::uint8_t>(4 * kind + 1),
                 static_cast<std::uint8_t>(5 * kind),
                 static_cast<std::uint8_t>(kind)};
    for (std::size_t i = 0; i < 40; ++i) {
      const float number = 0.05f * static_cast<float>(random() % 100);
      const auto* const begin = reinterpret_cast<const std::uint8_t*>(&number);
      points.insert(points.end(), begin, begin + sizeof(number));
    }
    writer.write("round_trip", "points_" + std::to_string(kind), points);
  }
}

} // namespace

int
main(int argc, char** argv)
{
  if (argc != 3) {
    std::cerr << "write_seeds TEST_DATA FOLDER\n";
    return 1;
  }
  const std::filesystem::path data(argv[1]);
  SeedWriter writer(argv[2]);
  for (const char* const folder : {"golden", "invalid"})
    writeFiles(data / folder, writer);
  writeSmallStreams(writer);
  writeChoices(writer);
  return writer.isGood() ? 0 : 1;
}
