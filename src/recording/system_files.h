// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

/** \file
 * What systems do differently with files: system_files_posix.cpp,
 * system_files_windows.cpp. Descriptors are C's; files are binary, and are closed in
 * programs that are started. Paths are those that std::filesystem takes. After a failure
 * errno says why. What is exported is for the program pcl_ext.
 */
#include <pcl_ext/export.h>
#include <pcl_ext/version.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording {

#ifdef _WIN32
constexpr bool can_rename_open_files = false;
#else
constexpr bool can_rename_open_files = true;
#endif

enum class FileType { Regular, Folder, Pipe, Device, Terminal };

/** \brief Opens a file, or a pipe, for whose writer waitForInput() waits.
 * \return the descriptor, or -1
 */
PCL_EXT_RECORDING_EXPORT int
openToRead(const std::string& path);

/** \brief Opens a file that nobody else is writing, or creates one; it keeps its bytes.
 * \return the descriptor, or -1; errno is EBUSY if somebody is writing it
 */
PCL_EXT_RECORDING_EXPORT int
openToWrite(const std::string& path);

/** \brief Creates a file that only this user may read.
 * \return the descriptor, or -1; errno is EEXIST if the name is taken
 */
int
createNew(const std::string& path);

/** \brief A descriptor of its own of the standard input, output or error (0, 1, 2).
 * \return the descriptor, or -1
 */
PCL_EXT_RECORDING_EXPORT int
duplicateStandard(int number);

PCL_EXT_RECORDING_EXPORT bool
closeFile(int descriptor);

/** \brief An open file, which is closed with this. */
class Descriptor {
public:
  /** \param[in] number of the file; -1: none */
  explicit Descriptor(int number = -1) : number_(number) {}

  ~Descriptor() { close(); }

  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}

  Descriptor&
  operator=(Descriptor&& other) noexcept
  {
    std::swap(number_, other.number_);
    return *this;
  }

  int
  get() const
  {
    return number_;
  }

  bool
  isOpen() const
  {
    return number_ >= 0;
  }

  /** \return false if closing failed; errno stays as it is if nothing is open */
  bool
  close()
  {
    return number_ < 0 || closeFile(std::exchange(number_, -1));
  }

private:
  int number_;
};

/** \param[out] size of a regular file
 * \return false if there is no such descriptor
 */
PCL_EXT_RECORDING_EXPORT bool
describeFile(int descriptor, FileType& type, std::uint64_t& size);

/** \brief A path at which an open file can be opened again; empty if the system knows
 * none. */
PCL_EXT_RECORDING_EXPORT std::string
pathOfOpenFile(int descriptor);

/** \brief When a file was changed.
 * \param[out] time_ns since 1970
 */
PCL_EXT_RECORDING_EXPORT bool
lastChange(const std::string& path, std::int64_t& time_ns);

/** \brief Waits until an input has bytes or has ended, or for a signal.
 * \return false if that is not so
 */
PCL_EXT_RECORDING_EXPORT bool
waitForInput(int descriptor, int timeout_ms);

/** \brief Reads what comes next.
 * \return the number of bytes, 0 at the end, or -1
 */
PCL_EXT_RECORDING_EXPORT std::ptrdiff_t
readNext(int descriptor, std::uint8_t* bytes, std::size_t count);

/** \brief Reads bytes of a regular file; several threads may.
 * \return false unless all of them were read
 */
bool
readAt(int descriptor, std::uint64_t offset, std::uint8_t* bytes, std::size_t count);

/** \return false if the descriptor takes no more of the bytes */
PCL_EXT_RECORDING_EXPORT bool
writeAll(int descriptor, const std::uint8_t* bytes, std::size_t count);

/** \brief Cuts a regular file at a size; what is written next comes there. */
PCL_EXT_RECORDING_EXPORT bool
truncateFile(int descriptor, std::uint64_t size);

/** \brief Waits until what was written is on the disk; not for pipes. */
bool
synchronise(int descriptor);

/** \brief Renames a file or folder, but replaces no file.
 * \return false if it failed; errno is EEXIST if the name is taken
 */
bool
renameToNewName(const std::string& from, const std::string& to);

} // namespace pcl_ext::PCL_EXT_ABI::recording
