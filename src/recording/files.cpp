// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/files.h"

#include "recording/system_files.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording {

namespace {

namespace fs = std::filesystem;

/** \brief The status of a system call that failed; EBUSY is ours, see openToWrite(). */
RecordingStatus
systemFailure(RecordingCode code, const std::string& path, const std::string& action)
{
  return {code,
          errno == EBUSY
              ? "another program is writing '" + path +
                    "': wait for its end, or name another file"
              : "cannot " + action + " '" + path + "': " + std::strerror(errno)};
}

/** \brief Creates or empties a file that nobody else is writing.
 * \return its descriptor, or -1
 */
int
openOutput(const std::string& path)
{
  const int descriptor = openToWrite(path);
  FileType type{};
  std::uint64_t size = 0;
  if (descriptor < 0 || (describeFile(descriptor, type, size) &&
                         (type != FileType::Regular || truncateFile(descriptor, 0))))
    return descriptor;
  const int error = errno;
  closeFile(descriptor);
  errno = error;
  return -1;
}

} // namespace

InputFile::~InputFile()
{
  if (descriptor_ >= 0)
    closeFile(descriptor_);
}

InputFile::InputFile(InputFile&& other) noexcept { *this = std::move(other); }

InputFile&
InputFile::operator=(InputFile&& other) noexcept
{
  std::swap(descriptor_, other.descriptor_);
  std::swap(copy_, other.copy_);
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
    closeFile(descriptor_);
  copy_ = TemporaryFile();
  descriptor_ = path == standard_stream ? duplicateStandard(0) : openToRead(path);
  FileType type{};
  if (descriptor_ < 0 || !describeFile(descriptor_, type, size_))
    return systemFailure(RecordingCode::InputFailed, path_, "open");
  if (type == FileType::Folder) {
    errno = EISDIR;
    return systemFailure(RecordingCode::InputFailed, path_, "read");
  }
  has_name_ = type == FileType::Regular && path != standard_stream;
  if (type == FileType::Regular)
    return {};
  TemporaryFile copy;
  RecordingStatus status = copyToTemporaryFile(descriptor_, path_, {}, {}, copy);
  return status.ok() ? replaceBy(std::move(copy)) : status;
}

RecordingStatus
InputFile::replaceBy(TemporaryFile&& copy)
{
  if (descriptor_ >= 0)
    closeFile(std::exchange(descriptor_, -1));
  has_name_ = false;
  copy_ = std::move(copy);
  FileType type{};
  return describeFile(copy_.descriptor(), type, size_)
             ? RecordingStatus()
             : systemFailure(RecordingCode::InputFailed, path_, "read");
}

void
InputFile::suspend()
{
  if (has_name_ && descriptor_ >= 0)
    closeFile(std::exchange(descriptor_, -1));
}

void
InputFile::resume()
{
  if (has_name_ && descriptor_ < 0)
    descriptor_ = openToRead(path_);
}

bool
InputFile::read(std::uint64_t offset, std::size_t count, std::uint8_t* bytes) const
{
  return offset <= size_ && count <= size_ - offset &&
         readAt(
             copy_.exists() ? copy_.descriptor() : descriptor_, offset, bytes, count);
}

OutputFile::~OutputFile()
{
  if (descriptor_ >= 0)
    closeFile(descriptor_);
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
    closeFile(descriptor_);
  descriptor_ = path == standard_stream ? duplicateStandard(1) : openOutput(path);
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
  const bool is_synchronised = synchronise(descriptor);
  return !closeFile(descriptor) || !is_synchronised
             ? systemFailure(RecordingCode::OutputFailed, path_, "write to")
             : RecordingStatus();
}

RecordingStatus
setAsideUnfinished(const std::string& path, const std::string& written_file)
{
  std::error_code ignored;
  const fs::file_status left = fs::status(path, ignored);
  if (!fs::is_regular_file(left) && !fs::is_directory(left))
    return {};
  // Nobody else may write it until it has the other name.
  errno = 0;
  int written = fs::exists(written_file, ignored) ? openToWrite(written_file) : -1;
  if (written < 0 && errno == EBUSY)
    return systemFailure(RecordingCode::OutputFailed, written_file, "write to");
  if (written >= 0 && !can_rename_open_files)
    closeFile(std::exchange(written, -1));
  bool is_done = false;
  if (fs::is_regular_file(left) && fs::file_size(path, ignored) == 0)
    is_done = fs::remove(path, ignored);
  else
    for (unsigned int number = 1; !is_done; ++number) {
      is_done = renameToNewName(path, path + '.' + std::to_string(number));
      if (!is_done && errno != EEXIST)
        break;
    }
  // Its writer may have completed it meanwhile.
  const RecordingStatus status =
      is_done || !fs::exists(path, ignored)
          ? RecordingStatus()
          : systemFailure(RecordingCode::OutputFailed, path, "rename");
  if (written >= 0)
    closeFile(written);
  return status;
}

RecordingStatus
renameFile(const std::string& from, const std::string& to, ExistingFile existing)
{
  if (existing == ExistingFile::Keep)
    return renameToNewName(from, to)
               ? RecordingStatus()
               : systemFailure(RecordingCode::OutputFailed, to, "write to");
  std::error_code error;
  fs::rename(from, to, error);
  return error ? RecordingStatus(RecordingCode::OutputFailed,
                                 "cannot write to '" + to + "': " + error.message())
               : RecordingStatus();
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
