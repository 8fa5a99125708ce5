// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/files.h"

#include <sqlite3.h>

#include <cstdint>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::recording::sqlite {

/** \brief Lets SQLite read a file through InputFile, and nothing else: it can open no
 * other file but the log of writes (WAL) that a recorder left beside it, and can write
 * none. Nobody else is expected to write the file meanwhile; there are no locks.
 */
class DatabaseFile {
public:
  /** \param[in] file must exist, at the same place, as long as this */
  explicit DatabaseFile(const InputFile& file);
  ~DatabaseFile();
  DatabaseFile(const DatabaseFile&) = delete;
  DatabaseFile&
  operator=(const DatabaseFile&) = delete;

  /** \brief For sqlite3_open_v2(). */
  const char*
  vfsName() const
  {
    return name_.c_str();
  }

  /** \brief True if there is a log of writes. */
  bool
  hasLog() const
  {
    return log_.size() > 0;
  }

  /** \brief True if there is the journal of a write that was not completed. The database
   * may then have parts of it. */
  bool
  hasJournal() const
  {
    return has_journal_;
  }

  const InputFile&
  file() const
  {
    return file_;
  }

  /** \brief Bytes of the pages that are whole; a part of one at the end of a file that
   * was cut off would be read as if it ended with zeros. */
  std::uint64_t
  size() const
  {
    return size_;
  }

  const InputFile&
  log() const
  {
    return log_;
  }

private:
  const InputFile& file_;
  std::uint64_t size_ = 0;
  InputFile log_;
  bool has_journal_ = false;
  std::string name_;
  sqlite3_vfs vfs_{};
};

} // namespace pcl_ext::PCL_EXT_ABI::recording::sqlite
