// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/system_files.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#ifdef __APPLE__
#include <sys/param.h>

#include <array>
#endif

namespace pcl_ext::PCL_EXT_ABI::recording {

namespace {

/** \brief True if a path is that of an open file still. */
bool
isAt(const std::string& path, int descriptor)
{
  struct stat opened {};
  struct stat named {};
  return ::fstat(descriptor, &opened) == 0 && ::stat(path.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

} // namespace

int
openToRead(const std::string& path)
{
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor >= 0)
    ::fcntl(descriptor, F_SETFL, ::fcntl(descriptor, F_GETFL) & ~O_NONBLOCK);
  return descriptor;
}

int
openToWrite(const std::string& path)
{
  for (;;) {
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor < 0)
      return -1;
    // A file system without locks does without.
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      ::close(descriptor);
      errno = EBUSY;
      return -1;
    }
    if (isAt(path, descriptor))
      return descriptor;
    // Its writer completed it meanwhile, and gave it its final name.
    ::close(descriptor);
  }
}

int
createNew(const std::string& path)
{
  return ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
}

int
duplicateStandard(int number)
{
  return ::dup(number);
}

bool
closeFile(int descriptor)
{
  return ::close(descriptor) == 0;
}

bool
describeFile(int descriptor, FileType& type, std::uint64_t& size)
{
  struct stat properties {};
  if (::fstat(descriptor, &properties) != 0)
    return false;
  const bool is_device = S_ISCHR(properties.st_mode) || S_ISBLK(properties.st_mode);
  type = S_ISREG(properties.st_mode)   ? FileType::Regular
         : S_ISDIR(properties.st_mode) ? FileType::Folder
         : ::isatty(descriptor) != 0   ? FileType::Terminal
         : is_device                   ? FileType::Device
                                       : FileType::Pipe;
  size = static_cast<std::uint64_t>(properties.st_size);
  return true;
}

std::string
pathOfOpenFile(int descriptor)
{
#ifdef __APPLE__
  std::array<char, MAXPATHLEN> path{};
  return ::fcntl(descriptor, F_GETPATH, path.data()) == 0 ? path.data() : "";
#else
  return "/proc/self/fd/" + std::to_string(descriptor);
#endif
}

bool
lastChange(const std::string& path, std::int64_t& time_ns)
{
  struct stat properties {};
  if (::stat(path.c_str(), &properties) != 0)
    return false;
#ifdef __APPLE__
  const timespec& time = properties.st_mtimespec;
#else
  const timespec& time = properties.st_mtim;
#endif
  time_ns = std::int64_t{1'000'000'000} * time.tv_sec + time.tv_nsec;
  return true;
}

bool
waitForInput(int descriptor, int timeout_ms)
{
  pollfd input{descriptor, POLLIN, 0};
  return ::poll(&input, 1, timeout_ms) > 0;
}

std::ptrdiff_t
readNext(int descriptor, std::uint8_t* bytes, std::size_t count)
{
  return ::read(descriptor, bytes, count);
}

bool
readAt(int descriptor, std::uint64_t offset, std::uint8_t* bytes, std::size_t count)
{
  while (count > 0) {
    const ssize_t read = ::pread(descriptor, bytes, count, static_cast<off_t>(offset));
    if (read < 0 && errno == EINTR)
      continue;
    if (read <= 0)
      return false;
    bytes += read;
    offset += static_cast<std::uint64_t>(read);
    count -= static_cast<std::size_t>(read);
  }
  return true;
}

bool
writeAll(int descriptor, const std::uint8_t* bytes, std::size_t count)
{
  while (count > 0) {
    const ssize_t written = ::write(descriptor, bytes, count);
    if (written < 0 && errno == EINTR)
      continue;
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
  return ::ftruncate(descriptor, static_cast<off_t>(size)) == 0 &&
         ::lseek(descriptor, 0, SEEK_END) >= 0;
}

bool
synchronise(int descriptor)
{
  // A pipe or a terminal has nothing to synchronise.
  return ::fsync(descriptor) == 0 || errno == EINVAL || errno == EROFS ||
         errno == ENOTSUP;
}

bool
renameToNewName(const std::string& from, const std::string& to)
{
#ifdef RENAME_NOREPLACE
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0)
    return true;
  if (errno != EINVAL && errno != ENOSYS)
    return false;
#endif
  // Some file systems and systems do not know it.
  if (::link(from.c_str(), to.c_str()) == 0)
    return ::unlink(from.c_str()) == 0;
  if (errno == EEXIST)
    return false;
  // A folder, which cannot replace a file; or a file system without links.
  if (::access(to.c_str(), F_OK) == 0) {
    errno = EEXIST;
    return false;
  }
  return std::rename(from.c_str(), to.c_str()) == 0;
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
