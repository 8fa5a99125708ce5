// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "recording/mcap_content.h"
#include "support/recorded_streams.h"

#include <gtest/gtest.h>

#include <sqlite3.h>
#include <zstd.h>

#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

/** \brief A database with the tables of rosbag2, of Humble unless tests add others. */
class DatabaseBag {
public:
  /** \param[in] has_log writes stay in the log (WAL) until this is destroyed */
  explicit DatabaseBag(const std::string& path, bool has_log = false)
  {
    EXPECT_EQ(sqlite3_open(path.c_str(), &database_), SQLITE_OK);
    execute("PRAGMA page_size = 1024");
    execute(has_log ? "PRAGMA journal_mode = WAL; PRAGMA wal_autocheckpoint = 0"
                    : "PRAGMA synchronous = OFF");
    execute(
        "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT);"
        "CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER, "
        "metadata TEXT);"
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT "
        "NOT NULL, serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT "
        "NULL);"
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, "
        "timestamp INTEGER NOT NULL, data BLOB NOT NULL);"
        "CREATE INDEX timestamp_idx ON messages (timestamp ASC)");
    execute("BEGIN");
  }

  ~DatabaseBag()
  {
    commit();
    sqlite3_close(database_);
  }

  DatabaseBag(const DatabaseBag&) = delete;
  DatabaseBag&
  operator=(const DatabaseBag&) = delete;

  void
  execute(const std::string& statements)
  {
    char* error = nullptr;
    EXPECT_EQ(sqlite3_exec(database_, statements.c_str(), nullptr, nullptr, &error),
              SQLITE_OK)
        << (error == nullptr ? "" : error);
    sqlite3_free(error);
  }

  void
  commit()
  {
    execute("COMMIT");
  }

  void
  addTopic(int id,
           const std::string& name,
           const std::string& type,
           const std::string& qos)
  {
    execute("INSERT INTO topics(id, name, type, serialization_format, "
            "offered_qos_profiles) VALUES(" +
            std::to_string(id) + ", '" + name + "', '" + type + "', 'cdr', '" + qos +
            "')");
  }

  void
  addMessage(int topic, std::int64_t time, const Bytes& bytes)
  {
    sqlite3_stmt* statement = nullptr;
    ASSERT_EQ(sqlite3_prepare_v2(database_,
                                 "INSERT INTO messages(topic_id, timestamp, data) "
                                 "VALUES(?, ?, ?)",
                                 -1,
                                 &statement,
                                 nullptr),
              SQLITE_OK);
    sqlite3_bind_int(statement, 1, topic);
    sqlite3_bind_int64(statement, 2, time);
    sqlite3_bind_blob(statement,
                      3,
                      bytes.empty() ? "" : static_cast<const void*>(bytes.data()),
                      static_cast<int>(bytes.size()),
                      SQLITE_TRANSIENT);
    EXPECT_EQ(sqlite3_step(statement), SQLITE_DONE);
    sqlite3_finalize(statement);
  }

private:
  sqlite3* database_ = nullptr;
};

inline Bytes
compressed(const Bytes& bytes)
{
  Bytes result(ZSTD_compressBound(bytes.size()));
  result.resize(
      ZSTD_compress(result.data(), result.size(), bytes.data(), bytes.size(), 1));
  return result;
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::test
