// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <sqlite3.h>

#include <cstdint>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::recording::sqlite {

/** \brief A query of a database. */
class Statement {
public:
  /** \brief Failures are those of step(). */
  Statement(sqlite3* database, const char* query)
  {
    if (sqlite3_prepare_v2(database, query, -1, &statement_, nullptr) != SQLITE_OK)
      statement_ = nullptr;
  }

  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement&
  operator=(const Statement&) = delete;

  bool
  isValid() const
  {
    return statement_ != nullptr;
  }

  /** \brief Begins again with another value of its parameter. */
  void
  bind(std::int64_t value)
  {
    sqlite3_reset(statement_);
    sqlite3_bind_int64(statement_, 1, value);
  }

  /** \return SQLITE_ROW, SQLITE_DONE or a failure */
  int
  step()
  {
    return statement_ == nullptr ? SQLITE_ERROR : sqlite3_step(statement_);
  }

  void
  reset()
  {
    sqlite3_reset(statement_);
  }

  bool
  isNumber(int column) const
  {
    return sqlite3_column_type(statement_, column) == SQLITE_INTEGER;
  }

  std::int64_t
  number(int column) const
  {
    return sqlite3_column_int64(statement_, column);
  }

  /** \brief A text; empty for -1, which is no column. */
  std::string
  text(int column) const
  {
    if (column < 0)
      return {};
    const unsigned char* const begin = sqlite3_column_text(statement_, column);
    const int size = sqlite3_column_bytes(statement_, column);
    return begin == nullptr ? std::string()
                            : std::string(reinterpret_cast<const char*>(begin),
                                          static_cast<std::size_t>(size));
  }

  /** \brief The number of a column by its name; -1: there is none. */
  int
  columnOf(const std::string& name) const
  {
    for (int column = 0; column < sqlite3_column_count(statement_); ++column)
      if (name == sqlite3_column_name(statement_, column))
        return column;
    return -1;
  }

private:
  sqlite3_stmt* statement_ = nullptr;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording::sqlite
