/** \file
 * A main for fuzz targets without a fuzzer: runs a target on files, on all files of
 * folders, and on some thousand random inputs.
 */
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <vector>

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

void
replay(const std::filesystem::path& path)
{
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> content{std::istreambuf_iterator<char>(file), {}};
  const std::vector<std::uint8_t> bytes(content.begin(), content.end());
  LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
}

} // namespace

int
main(int argc, char** argv)
{
  std::size_t inputs = 0;
  for (int i = 1; i < argc; ++i) {
    const std::filesystem::path path(argv[i]);
    if (std::filesystem::is_directory(path))
      for (const auto& entry : std::filesystem::directory_iterator(path)) {
        replay(entry.path());
        ++inputs;
      }
    else if (std::filesystem::exists(path)) {
      replay(path);
      ++inputs;
    }
    else {
      std::cerr << "replay: there is no '" << argv[i] << "'\n";
      return 1;
    }
  }
  std::mt19937 random(1);
  for (int i = 0; i < 5000; ++i, ++inputs) {
    std::vector<std::uint8_t> bytes(random() % 600);
    for (std::uint8_t& byte : bytes)
      byte = static_cast<std::uint8_t>(random());
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  }
  std::cout << inputs << " inputs\n";
}
