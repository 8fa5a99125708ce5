// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * A main for fuzz targets without a fuzzer: runs a target on files, on all files of
 * folders, and on a thousand others: what the target's mutator makes of the files;
 * where it has none, random bytes, and in turn files of which some bytes are changed.
 *
 *     fuzz_TARGET [--random=COUNT] [FILE or FOLDER ...]
 */
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

// Null in targets without one.
extern "C" [[gnu::weak]] std::size_t
LLVMFuzzerCustomMutator(std::uint8_t* data,
                        std::size_t size,
                        std::size_t max_size,
                        unsigned int seed);

extern "C" std::size_t
LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t most_bytes = std::size_t{1} << 13;

std::mt19937 random_numbers(1);

Bytes
contentOf(const std::filesystem::path& path)
{
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> content{std::istreambuf_iterator<char>(file), {}};
  return {content.begin(), content.end()};
}

bool
readFiles(const std::vector<std::string>& arguments, std::vector<Bytes>& inputs)
{
  for (const std::string& argument : arguments) {
    if (std::filesystem::is_directory(argument)) {
      for (const auto& entry : std::filesystem::recursive_directory_iterator(argument))
        if (entry.is_regular_file())
          inputs.push_back(contentOf(entry.path()));
    }
    else if (std::filesystem::exists(argument))
      inputs.push_back(contentOf(argument));
    else {
      std::cerr << "replay: there is no '" << argument << "'\n";
      return false;
    }
  }
  return true;
}

Bytes
randomInput(const std::vector<Bytes>& inputs)
{
  if (LLVMFuzzerCustomMutator != nullptr && !inputs.empty()) {
    Bytes bytes = inputs[random_numbers() % inputs.size()];
    const std::size_t size = bytes.size();
    bytes.resize(std::max(most_bytes, size));
    bytes.resize(LLVMFuzzerCustomMutator(
        bytes.data(), size, bytes.size(), static_cast<unsigned int>(random_numbers())));
    return bytes;
  }
  if (!inputs.empty() && random_numbers() % 2 == 0) {
    Bytes bytes = inputs[random_numbers() % inputs.size()];
    const std::size_t size = bytes.size();
    bytes.resize(size + 8);
    std::size_t changed = size;
    for (int changes = 0; changes < 3; ++changes)
      changed = LLVMFuzzerMutate(bytes.data(), changed, bytes.size());
    bytes.resize(changed);
    return bytes;
  }
  Bytes bytes(random_numbers() % 600);
  for (std::uint8_t& byte : bytes)
    byte = static_cast<std::uint8_t>(random_numbers());
  return bytes;
}

} // namespace

std::size_t
LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size)
{
  switch (random_numbers() % 4) {
  case 0: // longer
    if (size < max_size)
      data[size++] = static_cast<std::uint8_t>(random_numbers());
    break;
  case 1: // shorter
    if (size > 1)
      size -= 1 + random_numbers() % (size - 1);
    break;
  default:
    if (size > 0)
      data[random_numbers() % size] = static_cast<std::uint8_t>(random_numbers());
  }
  return size;
}

int
main(int argc, char** argv)
{
  std::vector<std::string> arguments(argv + 1, argv + argc);
  unsigned long random_inputs = 1000;
  const std::string option = "--random=";
  if (!arguments.empty() && arguments[0].compare(0, option.size(), option) == 0) {
    random_inputs = std::strtoul(arguments[0].c_str() + option.size(), nullptr, 10);
    arguments.erase(arguments.begin());
  }
  std::vector<Bytes> inputs;
  if (!readFiles(arguments, inputs))
    return 1;
  for (const Bytes& input : inputs)
    LLVMFuzzerTestOneInput(input.data(), input.size());
  for (unsigned long i = 0; i < random_inputs; ++i) {
    const Bytes input = randomInput(inputs);
    LLVMFuzzerTestOneInput(input.data(), input.size());
  }
  std::cout << inputs.size() + random_inputs << " inputs\n";
}
