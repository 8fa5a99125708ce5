// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/standard_input.h"

#include "console/interruption.h"
#include "recording/temporary_copy.h"

#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <vector>

namespace pcl_ext::tools {

namespace fs = std::filesystem;

namespace {

constexpr const char* standard_input = "-";

/** \brief Paths of copies by the path that the user gave: a pipe can be read once
 * only. */
std::map<std::string, std::string> copies;

/** \brief What is in these copies, until the program ends. */
std::vector<recording::TemporaryFile> temporary_files;

/** \brief Opens an input that is no regular file. A pipe without a writer is waited for
 * later, where an interruption ends it. */
recording::Descriptor
openInput(const std::string& path)
{
  recording::Descriptor descriptor(path == standard_input
                                       ? recording::duplicateStandard(0)
                                       : recording::openToRead(path));
  if (!descriptor.isOpen())
    throw std::runtime_error("cannot open '" + shownName(path) +
                             "': " + std::strerror(errno));
  return descriptor;
}

/** \brief The type of an input; that of the standard input by its descriptor. */
fs::file_type
typeOf(const std::string& path)
{
  std::error_code ignored;
  if (path != standard_input)
    return fs::status(path, ignored).type();
  recording::FileType type{};
  std::uint64_t size = 0;
  if (!recording::describeFile(0, type, size))
    return fs::file_type::none;
  switch (type) {
  case recording::FileType::Regular:
    return fs::file_type::regular;
  case recording::FileType::Folder:
    return fs::file_type::directory;
  case recording::FileType::Pipe:
    return fs::file_type::fifo;
  default:
    return fs::file_type::unknown;
  }
}

std::string
keepCopy(const std::string& path,
         const recording::Descriptor& input,
         const std::vector<std::uint8_t>& beginning)
{
  recording::TemporaryFile copy;
  const recording::RecordingStatus status = recording::copyToTemporaryFile(
      input.get(), shownName(path), [] { return !isInterrupted(); }, beginning, copy);
  if (!status.ok())
    throw std::runtime_error(status.message());
  temporary_files.push_back(std::move(copy));
  return temporary_files.back().path();
}

} // namespace

std::string
shownName(const std::string& path)
{
  return path == standard_input ? "standard input" : path;
}

bool
mustWaitFor(int descriptor)
{
  // Who writes a file into the pipe is a little slower than who reads it.
  constexpr int timeout_ms = 10;
  return !recording::waitForInput(descriptor, timeout_ms);
}

std::size_t
readPipe(int descriptor, std::uint8_t* bytes, std::size_t count)
{
  while (!isInterrupted()) {
    // Unlike reading it ends with a signal.
    constexpr int timeout_ms = 200;
    if (!recording::waitForInput(descriptor, timeout_ms))
      continue;
    const std::ptrdiff_t read = recording::readNext(descriptor, bytes, count);
    if (read >= 0)
      return static_cast<std::size_t>(read);
    if (errno != EINTR && errno != EAGAIN)
      throw std::runtime_error(std::string("reading a pipe failed: ") +
                               std::strerror(errno));
  }
  return 0;
}

std::optional<recording::Descriptor>
mcapPipeOf(const std::string& path)
{
  const fs::file_type type = typeOf(path);
  const bool is_pipe = type == fs::file_type::fifo || type == fs::file_type::socket;
  if (!is_pipe || copies.count(path) != 0)
    return std::nullopt;
  constexpr char magic[] = "\x89MCAP0\r\n";
  recording::Descriptor input = openInput(path);
  std::vector<std::uint8_t> beginning(sizeof(magic) - 1);
  std::size_t size = 0;
  while (size < beginning.size()) {
    const std::size_t read =
        readPipe(input.get(), &beginning[size], beginning.size() - size);
    if (read == 0)
      break;
    size += read;
  }
  beginning.resize(size);
  if (std::string(beginning.begin(), beginning.end()) == magic)
    return std::optional(std::move(input));
  copies[path] = keepCopy(path, input, beginning);
  return std::nullopt;
}

std::string
pathOfInput(const std::string& path)
{
  if (const auto known = copies.find(path); known != copies.end())
    return known->second;
  const fs::file_type type = typeOf(path);
  const bool is_file =
      type == fs::file_type::regular || type == fs::file_type::directory;
  if (path != standard_input &&
      (is_file || type == fs::file_type::none || type == fs::file_type::not_found))
    return path;
  std::string copy = is_file ? recording::pathOfOpenFile(0) : "";
  if (copy.empty())
    copy = keepCopy(path, openInput(path), {});
  return copies[path] = copy;
}

std::string
streamNameOfInput(const std::string& path)
{
  return path == standard_input ? "stdin" : fs::path(path).stem().string();
}

std::string
shown(std::string text)
{
  for (const auto& [given, copy] : copies)
    for (std::size_t at = 0; (at = text.find(copy, at)) != std::string::npos;) {
      const std::size_t end = at + copy.size();
      const bool is_longer =
          end < text.size() && std::isdigit(static_cast<unsigned char>(text[end])) != 0;
      if (!is_longer)
        text.replace(at, copy.size(), shownName(given));
      at += is_longer ? copy.size() : shownName(given).size();
    }
  return text;
}

} // namespace pcl_ext::tools
