#include "outputs/memory_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace pcl_ext {
namespace tools {

namespace {

[[noreturn]] void
fail(const std::string& what)
{
  throw std::runtime_error(what + ": " + std::strerror(errno));
}

/** \brief All bytes of a file. */
std::vector<char>
contentOf(int file)
{
  struct stat status {};
  if (::fstat(file, &status) != 0)
    fail("reading a file in memory failed");
  std::vector<char> bytes(static_cast<std::size_t>(status.st_size));
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::pread(
        file, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
    if (count <= 0)
      fail("reading a file in memory failed");
    done += static_cast<std::size_t>(count);
  }
  return bytes;
}

} // namespace

MemoryFile::MemoryFile() : file_(::memfd_create("cloud", 0))
{
  if (file_ < 0)
    fail("cannot make a file in memory");
  path_ = "/proc/self/fd/" + std::to_string(file_);
}

MemoryFile::~MemoryFile() { ::close(file_); }

void
MemoryFile::copyTo(const std::string& path) const
{
  const std::vector<char> bytes = contentOf(file_);
  const int output = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  if (output < 0)
    fail("cannot write '" + path + "'");
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::write(output, bytes.data() + done, bytes.size() - done);
    if (count <= 0) {
      const int reason = errno;
      ::close(output);
      ::unlink(path.c_str());
      errno = reason;
      fail("cannot write '" + path + "'");
    }
    done += static_cast<std::size_t>(count);
  }
  if (::close(output) != 0)
    fail("cannot write '" + path + "'");
}

} // namespace tools
} // namespace pcl_ext
