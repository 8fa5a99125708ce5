// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/system_files.h"

#include <fcntl.h>
#include <io.h>
#include <share.h>
#include <sys/stat.h>
#include <windows.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::recording {

namespace {

constexpr int usual_flags = _O_BINARY | _O_NOINHERIT;

/** \brief Bytes that one call reads or writes at most. */
constexpr std::size_t most_bytes = std::numeric_limits<int>::max();

int
open(const std::string& path, int flags, int sharing)
{
  int descriptor = -1;
  ::_wsopen_s(&descriptor,
              std::filesystem::path(path).c_str(),
              flags | usual_flags,
              sharing,
              _S_IREAD | _S_IWRITE);
  if (descriptor < 0 && _doserrno == ERROR_SHARING_VIOLATION)
    errno = EBUSY;
  return descriptor;
}

HANDLE
handleOf(int descriptor)
{
  return reinterpret_cast<HANDLE>(::_get_osfhandle(descriptor));
}

} // namespace

int
openToRead(const std::string& path)
{
  const int descriptor = open(path, _O_RDONLY, _SH_DENYNO);
  std::error_code ignored;
  if (descriptor < 0 && std::filesystem::is_directory(path, ignored))
    errno = EISDIR;
  return descriptor;
}

int
openToWrite(const std::string& path)
{
  return open(path, _O_WRONLY | _O_CREAT, _SH_DENYWR);
}

int
createNew(const std::string& path)
{
  return open(path, _O_RDWR | _O_CREAT | _O_EXCL, _SH_DENYNO);
}

int
duplicateStandard(int number)
{
  const int descriptor = ::_dup(number);
  if (descriptor >= 0)
    ::_setmode(descriptor, _O_BINARY);
  return descriptor;
}

bool
closeFile(int descriptor)
{
  return ::_close(descriptor) == 0;
}

bool
describeFile(int descriptor, FileType& type, std::uint64_t& size)
{
  const HANDLE handle = handleOf(descriptor);
  DWORD mode = 0;
  switch (::GetFileType(handle)) {
  case FILE_TYPE_DISK:
    type = FileType::Regular;
    break;
  case FILE_TYPE_PIPE:
    type = FileType::Pipe;
    break;
  case FILE_TYPE_CHAR:
    type = ::GetConsoleMode(handle, &mode) != 0 ? FileType::Terminal : FileType::Device;
    break;
  default:
    errno = EBADF;
    return false;
  }
  LARGE_INTEGER bytes{};
  if (type == FileType::Regular && ::GetFileSizeEx(handle, &bytes) == 0) {
    errno = EIO;
    return false;
  }
  size = static_cast<std::uint64_t>(bytes.QuadPart);
  return true;
}

std::string
pathOfOpenFile(int descriptor)
{
  std::wstring path(MAX_PATH, L'\0');
  for (;;) {
    const DWORD length = ::GetFinalPathNameByHandleW(
        handleOf(descriptor), path.data(), static_cast<DWORD>(path.size()), 0);
    const bool is_whole = length < path.size();
    path.resize(length);
    if (is_whole)
      return std::filesystem::path(path).string();
  }
}

bool
lastChange(const std::string& path, std::int64_t& time_ns)
{
  WIN32_FILE_ATTRIBUTE_DATA properties{};
  if (::GetFileAttributesExW(std::filesystem::path(path).c_str(),
                             GetFileExInfoStandard,
                             &properties) == 0) {
    errno = ENOENT;
    return false;
  }
  ULARGE_INTEGER time{};
  time.LowPart = properties.ftLastWriteTime.dwLowDateTime;
  time.HighPart = properties.ftLastWriteTime.dwHighDateTime;
  constexpr std::int64_t year_1970 = 116'444'736'000'000'000; // from 1601, in 100 ns
  time_ns = 100 * (static_cast<std::int64_t>(time.QuadPart) - year_1970);
  return true;
}

bool
waitForInput(int descriptor, int timeout_ms)
{
  constexpr int step_ms = 5;
  for (int waited_ms = 0;; waited_ms += step_ms) {
    DWORD available = 0;
    // It fails for files, and for pipes without a writer.
    if (::PeekNamedPipe(
            handleOf(descriptor), nullptr, 0, nullptr, &available, nullptr) == 0 ||
        available > 0)
      return true;
    if (waited_ms >= timeout_ms)
      return false;
    ::Sleep(step_ms);
  }
}

std::ptrdiff_t
readNext(int descriptor, std::uint8_t* bytes, std::size_t count)
{
  return ::_read(
      descriptor, bytes, static_cast<unsigned int>(std::min(count, most_bytes)));
}

bool
readAt(int descriptor, std::uint64_t offset, std::uint8_t* bytes, std::size_t count)
{
  while (count > 0) {
    OVERLAPPED place{};
    place.Offset = static_cast<DWORD>(offset);
    place.OffsetHigh = static_cast<DWORD>(offset >> 32u);
    DWORD read = 0;
    if (::ReadFile(handleOf(descriptor),
                   bytes,
                   static_cast<DWORD>(std::min(count, most_bytes)),
                   &read,
                   &place) == 0 ||
        read == 0)
      return false;
    bytes += read;
    offset += read;
    count -= read;
  }
  return true;
}

bool
writeAll(int descriptor, const std::uint8_t* bytes, std::size_t count)
{
  while (count > 0) {
    const int written = ::_write(
        descriptor, bytes, static_cast<unsigned int>(std::min(count, most_bytes)));
    if (written <= 0)
      return false;
    bytes += written;
    count -= static_cast<std::size_t>(written);
  }
  return true;
}

bool
truncateFile(int descriptor, std::uint64_t size)
{
  return ::_chsize_s(descriptor, static_cast<std::int64_t>(size)) == 0 &&
         ::_lseeki64(descriptor, 0, SEEK_END) >= 0;
}

bool
synchronise(int descriptor)
{
  FileType type{};
  std::uint64_t size = 0;
  return describeFile(descriptor, type, size) &&
         (type != FileType::Regular || ::_commit(descriptor) == 0);
}

bool
renameToNewName(const std::string& from, const std::string& to)
{
  return ::_wrename(std::filesystem::path(from).c_str(),
                    std::filesystem::path(to).c_str()) == 0;
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
