// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_status.h>

#include "recording/system_files.h"
#include "recording/temporary_copy.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief What is added to the name of a file until it is complete. */
constexpr char unfinished_suffix[] = ".unfinished";

/** \brief The path that stands for the standard input or output. */
constexpr char standard_stream[] = "-";

/** \brief A file that is read at any offset. */
class InputFile {
public:
  /** \brief Opens a file. An input that cannot seek, such as a pipe, is copied into a
   * temporary file first, see copyToTemporaryFile().
   * \param[in] path a file, or - for the standard input
   */
  RecordingStatus
  open(const std::string& path);

  /** \brief Takes the bytes of a temporary file in place of its own; the path stays. */
  RecordingStatus
  replaceBy(TemporaryFile&& copy);

  /** \brief Closes the file until resume(); what has no name, such as a pipe, stays
   * open. */
  void
  suspend();

  /** \brief Opens the file again after suspend(). If that fails, so does read(). */
  void
  resume();

  /** \brief Bytes of the file when it was opened. */
  std::uint64_t
  size() const
  {
    return size_;
  }

  /** \brief Path as it was given, for messages. */
  const std::string&
  path() const
  {
    return path_;
  }

  /** \brief Reads bytes from an offset.
   * \return false unless all of them were read
   */
  bool
  read(std::uint64_t offset, std::size_t count, std::uint8_t* bytes) const;

private:
  Descriptor descriptor_;
  TemporaryFile copy_;    // of an input that cannot seek
  bool has_name_ = false; // it can be opened again
  std::uint64_t size_ = 0;
  std::string path_;
};

/** \brief A file that is written from its beginning to its end. Without close() it stays
 * as it is. */
class OutputFile {
public:
  /** \brief Creates a file, or empties the one that exists, unless somebody writes it.
   * \param[in] path a file, or - for the standard output
   */
  RecordingStatus
  open(const std::string& path);

  RecordingStatus
  write(const std::uint8_t* bytes, std::size_t count);

  /** \brief Closes the file; the bytes are on the disk then. */
  RecordingStatus
  close();

  /** \brief Number of bytes written. */
  std::uint64_t
  position() const
  {
    return position_;
  }

  const std::string&
  path() const
  {
    return path_;
  }

private:
  Descriptor descriptor_;
  std::uint64_t position_ = 0;
  std::string path_;
};

/** \brief Keeps what a recorder left that did not end: the unfinished file or folder
 * gets a name with a number after it. An empty file is removed.
 * \param[in] path the unfinished file or folder; nothing is done if there is none
 * \param[in] written_file the file that its writer has locked: itself, or one in the
 * folder
 * \return OutputFailed if another writer is writing it
 */
PCL_EXT_RECORDING_EXPORT RecordingStatus
setAsideUnfinished(const std::string& path, const std::string& written_file);

/** \brief Gives a complete file or folder its name.
 * \param[in] existing what becomes of a file of that name
 */
PCL_EXT_RECORDING_EXPORT RecordingStatus
renameFile(const std::string& from, const std::string& to, ExistingFile existing);

} // namespace pcl_ext::PCL_EXT_ABI::recording
