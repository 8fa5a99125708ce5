#include "recording/files.h"

#include "recording/temporary_copy.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>
#include <utility>

namespace pcl_ext {
namespace recording {

namespace {

/** \brief The status of a system call that failed; EBUSY is ours, see openOutput(). */
RecordingStatus
systemFailure(RecordingCode code, const std::string& path, const std::string& action)
{
  return {code,
          errno == EBUSY
              ? "another program is writing '" + path + "'"
              : "cannot " + action + " '" + path + "': " + std::strerror(errno)};
}

/** \brief Creates or empties a file that nobody else is writing.
 * \return its descriptor, or -1
 */
int
openOutput(const std::string& path)
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
    struct stat opened {};
    struct stat named {};
    const bool is_named =
        ::fstat(descriptor, &opened) == 0 && ::stat(path.c_str(), &named) == 0 &&
        opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
    if (is_named && (!S_ISREG(opened.st_mode) || ::ftruncate(descriptor, 0) == 0))
      return descriptor;
    // Its writer completed it meanwhile, and gave it its final name.
    const int error = errno;
    ::close(descriptor);
    errno = error;
    if (is_named)
      return -1;
  }
}

} // namespace

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

InputFile::~InputFile()
{
  if (descriptor_ >= 0)
    ::close(descriptor_);
}

InputFile::InputFile(InputFile&& other) noexcept { *this = std::move(other); }

InputFile&
InputFile::operator=(InputFile&& other) noexcept
{
  std::swap(descriptor_, other.descriptor_);
  std::swap(has_name_, other.has_name_);
  std::swap(size_, other.size_);
  std::swap(path_, other.path_);
  return *this;
}

RecordingStatus
InputFile::open(const std::string& path)
{
  path_ = path == standard_stream ? "standard input" : path;
  if (descriptor_ >= 0)
    ::close(descriptor_);
  descriptor_ = path == standard_stream ? ::dup(STDIN_FILENO)
                                        : ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat properties {};
  if (descriptor_ < 0 || ::fstat(descriptor_, &properties) != 0)
    return systemFailure(RecordingCode::InputFailed, path_, "open");
  if (S_ISDIR(properties.st_mode)) {
    errno = EISDIR;
    return systemFailure(RecordingCode::InputFailed, path_, "read");
  }
  has_name_ = S_ISREG(properties.st_mode) && path != standard_stream;
  if (!S_ISREG(properties.st_mode)) {
    int copy = -1;
    if (RecordingStatus status = copyToTemporaryFile(descriptor_, path_, {}, {}, copy);
        !status.ok())
      return status;
    ::close(descriptor_);
    descriptor_ = copy;
    if (::fstat(descriptor_, &properties) != 0)
      return systemFailure(RecordingCode::InputFailed, path_, "read");
  }
  size_ = static_cast<std::uint64_t>(properties.st_size);
  return {};
}

void
InputFile::suspend()
{
  if (has_name_ && descriptor_ >= 0)
    ::close(std::exchange(descriptor_, -1));
}

void
InputFile::resume()
{
  if (has_name_ && descriptor_ < 0)
    descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
}

bool
InputFile::read(std::uint64_t offset, std::size_t count, std::uint8_t* bytes) const
{
  if (offset > size_ || count > size_ - offset)
    return false;
  while (count > 0) {
    const ssize_t read = ::pread(descriptor_, bytes, count, static_cast<off_t>(offset));
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

OutputFile::~OutputFile()
{
  if (descriptor_ >= 0)
    ::close(descriptor_);
}

OutputFile::OutputFile(OutputFile&& other) noexcept { *this = std::move(other); }

OutputFile&
OutputFile::operator=(OutputFile&& other) noexcept
{
  std::swap(descriptor_, other.descriptor_);
  std::swap(position_, other.position_);
  std::swap(path_, other.path_);
  return *this;
}

RecordingStatus
OutputFile::open(const std::string& path)
{
  path_ = path == standard_stream ? "standard output" : path;
  position_ = 0;
  if (descriptor_ >= 0)
    ::close(descriptor_);
  descriptor_ = path == standard_stream ? ::dup(STDOUT_FILENO) : openOutput(path);
  return descriptor_ < 0 ? systemFailure(RecordingCode::OutputFailed, path_, "write to")
                         : RecordingStatus();
}

RecordingStatus
OutputFile::write(const std::uint8_t* bytes, std::size_t count)
{
  if (!writeAll(descriptor_, bytes, count))
    return systemFailure(RecordingCode::OutputFailed, path_, "write to");
  position_ += count;
  return {};
}

RecordingStatus
OutputFile::close()
{
  const int descriptor = std::exchange(descriptor_, -1);
  // A pipe or a terminal has nothing to synchronise.
  const bool is_synchronised =
      ::fsync(descriptor) == 0 || errno == EINVAL || errno == EROFS || errno == ENOTSUP;
  return ::close(descriptor) != 0 || !is_synchronised
             ? systemFailure(RecordingCode::OutputFailed, path_, "write to")
             : RecordingStatus();
}

RecordingStatus
setAsideUnfinished(const std::string& path, const std::string& written_file)
{
  struct stat properties {};
  if (::stat(path.c_str(), &properties) != 0 ||
      (!S_ISREG(properties.st_mode) && !S_ISDIR(properties.st_mode)))
    return {};
  const int written = ::open(written_file.c_str(), O_RDONLY | O_CLOEXEC);
  if (written >= 0 && ::flock(written, LOCK_EX | LOCK_NB) != 0 &&
      errno == EWOULDBLOCK) {
    ::close(written);
    errno = EBUSY;
    return systemFailure(RecordingCode::OutputFailed, written_file, "write to");
  }
  bool is_done = false;
  if (S_ISREG(properties.st_mode) && properties.st_size == 0)
    is_done = ::unlink(path.c_str()) == 0;
  else
    for (unsigned int number = 1; !is_done; ++number) {
      const std::string name = path + '.' + std::to_string(number);
      if (::access(name.c_str(), F_OK) == 0)
        continue;
      if (std::rename(path.c_str(), name.c_str()) != 0)
        break;
      is_done = true;
    }
  // Its writer may have completed it meanwhile.
  const RecordingStatus status =
      is_done || errno == ENOENT
          ? RecordingStatus()
          : systemFailure(RecordingCode::OutputFailed, path, "rename");
  if (written >= 0)
    ::close(written);
  return status;
}

namespace {

/** \brief Renames a file or folder, but replaces no file.
 * \return 0, or -1 with errno, which is EEXIST if there is one
 */
int
renameToNewName(const char* from, const char* to)
{
#ifdef RENAME_NOREPLACE
  if (::renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_NOREPLACE) == 0)
    return 0;
  if (errno != EINVAL && errno != ENOSYS)
    return -1;
#endif
  // Some file systems do not know it.
  if (::link(from, to) == 0)
    return ::unlink(from);
  if (errno == EEXIST)
    return -1;
  // A folder, which cannot replace a file; or a file system without links.
  if (::access(to, F_OK) == 0) {
    errno = EEXIST;
    return -1;
  }
  return std::rename(from, to);
}

} // namespace

RecordingStatus
renameFile(const std::string& from, const std::string& to, ExistingFile existing)
{
  const int result = existing == ExistingFile::Replace
                         ? std::rename(from.c_str(), to.c_str())
                         : renameToNewName(from.c_str(), to.c_str());
  return result != 0 ? systemFailure(RecordingCode::OutputFailed, to, "write to")
                     : RecordingStatus();
}

} // namespace recording
} // namespace pcl_ext
