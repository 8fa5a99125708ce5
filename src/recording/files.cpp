// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/files.h"

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

/** \brief Creates or empties a file that nobody else is writing. */
bool
openOutput(const std::string& path, Descriptor& descriptor)
{
  descriptor = Descriptor(openToWrite(path));
  FileType type{};
  std::uint64_t size = 0;
  return descriptor.isOpen() && describeFile(descriptor.get(), type, size) &&
         (type != FileType::Regular || truncateFile(descriptor.get(), 0));
}

} // namespace

RecordingStatus
InputFile::open(const std::string& path)
{
  path_ = path == standard_stream ? "standard input" : path;
  descriptor_.close();
  copy_ = TemporaryFile();
  descriptor_ =
      Descriptor(path == standard_stream ? duplicateStandard(0) : openToRead(path));
  FileType type{};
  if (!descriptor_.isOpen() || !describeFile(descriptor_.get(), type, size_))
    return systemFailure(RecordingCode::InputFailed, path_, "open");
  if (type == FileType::Folder) {
    errno = EISDIR;
    return systemFailure(RecordingCode::InputFailed, path_, "read");
  }
  has_name_ = type == FileType::Regular && path != standard_stream;
  if (type == FileType::Regular)
    return {};
  TemporaryFile copy;
  RecordingStatus status = copyToTemporaryFile(descriptor_.get(), path_, {}, {}, copy);
  return status.ok() ? replaceBy(std::move(copy)) : status;
}

RecordingStatus
InputFile::replaceBy(TemporaryFile&& copy)
{
  descriptor_.close();
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
  if (has_name_)
    descriptor_.close();
}

void
InputFile::resume()
{
  if (has_name_ && !descriptor_.isOpen())
    descriptor_ = Descriptor(openToRead(path_));
}

bool
InputFile::read(std::uint64_t offset, std::size_t count, std::uint8_t* bytes) const
{
  return offset <= size_ && count <= size_ - offset &&
         readAt(copy_.exists() ? copy_.descriptor() : descriptor_.get(),
                offset,
                bytes,
                count);
}

RecordingStatus
OutputFile::open(const std::string& path)
{
  path_ = path == standard_stream ? "standard output" : path;
  position_ = 0;
  descriptor_.close();
  if (path == standard_stream)
    descriptor_ = Descriptor(duplicateStandard(1));
  const bool is_open =
      path == standard_stream ? descriptor_.isOpen() : openOutput(path, descriptor_);
  return is_open ? RecordingStatus()
                 : systemFailure(RecordingCode::OutputFailed, path_, "write to");
}

RecordingStatus
OutputFile::write(const std::uint8_t* bytes, std::size_t count)
{
  if (!writeAll(descriptor_.get(), bytes, count))
    return systemFailure(RecordingCode::OutputFailed, path_, "write to");
  position_ += count;
  return {};
}

RecordingStatus
OutputFile::close()
{
  const bool is_synchronised = synchronise(descriptor_.get());
  return descriptor_.close() && is_synchronised
             ? RecordingStatus()
             : systemFailure(RecordingCode::OutputFailed, path_, "write to");
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
  Descriptor written(fs::exists(written_file, ignored) ? openToWrite(written_file)
                                                       : -1);
  if (!written.isOpen() && errno == EBUSY)
    return systemFailure(RecordingCode::OutputFailed, written_file, "write to");
  if (!can_rename_open_files)
    written.close();
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
  return is_done || !fs::exists(path, ignored)
             ? RecordingStatus()
             : systemFailure(RecordingCode::OutputFailed, path, "rename");
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
