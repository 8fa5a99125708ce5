// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/sqlite/database_file.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace pcl_ext::PCL_EXT_ABI::recording::sqlite {

namespace {

namespace fs = std::filesystem;

/** \brief What SQLite has of an open file; it allocates and frees it. */
struct OpenFile {
  sqlite3_file base; // must be first
  const InputFile* file;
  std::uint64_t size;
};

const OpenFile&
fileOf(sqlite3_file* open)
{
  return *reinterpret_cast<OpenFile*>(open);
}

/** \brief Bytes of the whole pages of a database. */
std::uint64_t
sizeOfPages(const InputFile& file)
{
  std::array<std::uint8_t, 2> field{};
  constexpr std::uint64_t offset_of_field = 16;
  if (!file.read(offset_of_field, field.size(), field.data()))
    return file.size();
  constexpr std::uint64_t largest_page = 65536; // which the field has as 1
  const std::uint64_t number = std::uint64_t{field[0]} << 8 | field[1];
  const std::uint64_t page = number == 1 ? largest_page : number;
  return page == 0 ? file.size() : file.size() - file.size() % page;
}

int
closeNothing(sqlite3_file* /* open */)
{
  return SQLITE_OK;
}

int
readBytes(sqlite3_file* open, void* bytes, int count, sqlite3_int64 offset)
{
  const OpenFile& file = fileOf(open);
  const auto wanted = static_cast<std::size_t>(count);
  const auto begin = static_cast<std::uint64_t>(offset);
  const auto there = static_cast<std::size_t>(
      std::min<std::uint64_t>(wanted, file.size - std::min(begin, file.size)));
  auto* const target = static_cast<std::uint8_t*>(bytes);
  if (there > 0 && !file.file->read(begin, there, target))
    return SQLITE_IOERR_READ;
  if (there == wanted)
    return SQLITE_OK;
  std::memset(target + there, 0, wanted - there);
  return SQLITE_IOERR_SHORT_READ;
}

int
refuseToWrite(sqlite3_file* /* open */,
              const void* /* bytes */,
              int /* count */,
              sqlite3_int64 /* offset */)
{
  return SQLITE_READONLY;
}

int
refuseToTruncate(sqlite3_file* /* open */, sqlite3_int64 /* size */)
{
  return SQLITE_READONLY;
}

int
ignore(sqlite3_file* /* open */, int /* value */)
{
  return SQLITE_OK;
}

int
sizeOf(sqlite3_file* open, sqlite3_int64* size)
{
  *size = static_cast<sqlite3_int64>(fileOf(open).size);
  return SQLITE_OK;
}

int
isReserved(sqlite3_file* /* open */, int* is_reserved)
{
  *is_reserved = 0;
  return SQLITE_OK;
}

int
controlNothing(sqlite3_file* /* open */, int /* operation */, void* /* argument */)
{
  return SQLITE_NOTFOUND;
}

int
zeroOf(sqlite3_file* /* open */)
{
  return 0;
}

// Version 1 has no shared memory: the index of the log is in memory of the process.
const sqlite3_io_methods methods = {1,
                                    closeNothing,
                                    readBytes,
                                    refuseToWrite,
                                    refuseToTruncate,
                                    ignore,
                                    sizeOf,
                                    ignore,
                                    ignore,
                                    isReserved,
                                    controlNothing,
                                    zeroOf,
                                    zeroOf,
                                    nullptr,
                                    nullptr,
                                    nullptr,
                                    nullptr,
                                    nullptr,
                                    nullptr};

int
openFile(sqlite3_vfs* vfs,
         const char* /* name */,
         sqlite3_file* open,
         int flags,
         int* flags_of_open)
{
  open->pMethods = nullptr;
  const auto& database = *static_cast<const DatabaseFile*>(vfs->pAppData);
  const bool is_database = (flags & SQLITE_OPEN_MAIN_DB) != 0;
  if (!is_database && (flags & SQLITE_OPEN_WAL) == 0)
    return SQLITE_CANTOPEN;
  auto& opened = *reinterpret_cast<OpenFile*>(open);
  opened.file = is_database ? &database.file() : &database.log();
  opened.size = is_database ? database.size() : database.log().size();
  open->pMethods = &methods;
  if (flags_of_open != nullptr)
    *flags_of_open =
        (flags & ~(SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE)) | SQLITE_OPEN_READONLY;
  return SQLITE_OK;
}

int
refuseToDelete(sqlite3_vfs* /* vfs */, const char* /* name */, int /* synchronise */)
{
  return SQLITE_READONLY;
}

/** \brief Only the log is there besides the database. */
int
findFile(sqlite3_vfs* vfs, const char* name, int /* flags */, int* is_there)
{
  constexpr char suffix[] = "-wal";
  const std::size_t length = std::strlen(name);
  const std::size_t suffix_length = sizeof(suffix) - 1;
  *is_there = length > suffix_length &&
                      std::strcmp(name + length - suffix_length, suffix) == 0 &&
                      static_cast<const DatabaseFile*>(vfs->pAppData)->hasLog()
                  ? 1
                  : 0;
  return SQLITE_OK;
}

int
copyName(sqlite3_vfs* /* vfs */, const char* name, int size, char* full_name)
{
  sqlite3_snprintf(size, full_name, "%s", name);
  return SQLITE_OK;
}

} // namespace

DatabaseFile::DatabaseFile(const InputFile& file)
: file_(file)
, size_(sizeOfPages(file))
, name_("pcl_ext " + std::to_string(reinterpret_cast<std::uintptr_t>(this)))
{
  std::error_code ignored;
  if (fs::is_regular_file(file.path() + "-wal", ignored) &&
      !log_.open(file.path() + "-wal").ok())
    log_ = InputFile();
  has_journal_ = fs::is_regular_file(file.path() + "-journal", ignored) &&
                 fs::file_size(file.path() + "-journal", ignored) > 0 && !ignored;
  sqlite3_initialize();
  const sqlite3_vfs* const usual = sqlite3_vfs_find(nullptr);
  if (usual == nullptr)
    return;
  vfs_ = *usual; // what it has of time, randomness and memory
  vfs_.pNext = nullptr;
  vfs_.szOsFile = sizeof(OpenFile);
  vfs_.zName = name_.c_str();
  vfs_.pAppData = this;
  vfs_.xOpen = openFile;
  vfs_.xDelete = refuseToDelete;
  vfs_.xAccess = findFile;
  vfs_.xFullPathname = copyName;
  sqlite3_vfs_register(&vfs_, 0);
}

DatabaseFile::~DatabaseFile() { sqlite3_vfs_unregister(&vfs_); }

} // namespace pcl_ext::PCL_EXT_ABI::recording::sqlite
