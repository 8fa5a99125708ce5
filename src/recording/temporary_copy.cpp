// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/temporary_copy.h"

#include "recording/system_files.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <random>
#include <system_error>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording {

namespace {

namespace fs = std::filesystem;

#ifdef __linux__
constexpr bool needs_name = false; // to be opened again
#else
constexpr bool needs_name = true;
#endif

RecordingStatus
failure(const std::string& what)
{
  return {RecordingCode::InputFailed, what + ": " + std::strerror(errno)};
}

/** \brief Why an input is refused; empty if it is not. */
std::string
whyRefused(int input, const std::string& name)
{
  FileType type{};
  std::uint64_t size = 0;
  if (!describeFile(input, type, size))
    return {};
  return type == FileType::Terminal
             ? "'" + name + "' is a terminal: name a file, or pipe one into the program"
         : type == FileType::Device
             ? "'" + name + "' is a device: only files and pipes can be read"
             : "";
}

RecordingStatus
copyAll(int input,
        const std::string& name,
        const std::function<bool()>& is_wanted,
        int copy)
{
  std::array<std::uint8_t, std::size_t{1} << 16> buffer;
  for (;;) {
    // Unlike reading it ends with each signal, also one whose calls are restarted; a
    // signal that came before it is noticed after the timeout.
    constexpr int timeout_ms = 200;
    const bool is_ready = waitForInput(input, timeout_ms);
    if (is_wanted && !is_wanted())
      return {RecordingCode::InputFailed, "interrupted while reading '" + name + "'"};
    if (!is_ready)
      continue;
    const std::ptrdiff_t count = readNext(input, buffer.data(), buffer.size());
    if (count < 0 && (errno == EINTR || errno == EAGAIN))
      continue;
    if (count < 0)
      return failure("cannot read '" + name + "'");
    if (count == 0)
      return {};
    if (!writeAll(copy, buffer.data(), static_cast<std::size_t>(count)))
      return failure("cannot keep '" + name + "' in a temporary file");
  }
}

} // namespace

TemporaryFile::~TemporaryFile()
{
  if (!exists())
    return;
  closeFile(descriptor_);
  std::error_code ignored;
  if (needs_name)
    fs::remove(path_, ignored);
}

TemporaryFile::TemporaryFile(TemporaryFile&& other) noexcept
{
  *this = std::move(other);
}

TemporaryFile&
TemporaryFile::operator=(TemporaryFile&& other) noexcept
{
  std::swap(descriptor_, other.descriptor_);
  std::swap(path_, other.path_);
  return *this;
}

bool
TemporaryFile::create()
{
  *this = TemporaryFile();
  std::error_code error;
  const fs::path folder = fs::temp_directory_path(error);
  if (error) {
    errno = error.default_error_condition().value();
    return false;
  }
  std::random_device random;
  int descriptor = -1;
  do {
    path_ = (folder / ("pcl_ext" + std::to_string(random()))).string();
    descriptor = createNew(path_);
  }
  while (descriptor < 0 && errno == EEXIST);
  if (descriptor < 0)
    return false;
  descriptor_ = descriptor;
  if (needs_name)
    return true;
  fs::remove(path_, error);
  path_ = pathOfOpenFile(descriptor_);
  return true;
}

RecordingStatus
copyToTemporaryFile(int input,
                    const std::string& name,
                    const std::function<bool()>& is_wanted,
                    const std::vector<std::uint8_t>& beginning,
                    TemporaryFile& copy)
{
  if (const std::string reason = whyRefused(input, name); !reason.empty())
    return {RecordingCode::InputFailed, reason};
  TemporaryFile made;
  if (!made.create())
    return failure("cannot make a temporary file for '" + name + "'");
  RecordingStatus status =
      writeAll(made.descriptor(), beginning.data(), beginning.size())
          ? copyAll(input, name, is_wanted, made.descriptor())
          : failure("cannot keep '" + name + "' in a temporary file");
  if (status.ok())
    copy = std::move(made);
  return status;
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
