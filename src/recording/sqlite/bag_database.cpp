// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/sqlite/bag_database.h"

#include "recording/point_cloud_messages.h"
#include "recording/rosbag2_folder.h"
#include "recording/sqlite/database_file.h"
#include "recording/sqlite/statement.h"

#include <limits>
#include <map>
#include <tuple>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording::sqlite {

namespace {

constexpr std::size_t max_topics = std::numeric_limits<std::uint16_t>::max();
constexpr std::size_t max_topic_bytes = std::size_t{1} << 24; // of all texts
constexpr std::size_t max_definition_bytes = std::size_t{1} << 26;

/** \brief Operations of SQLite after which a query counts as endless, in units. */
constexpr int operations_in_unit = 100'000;
constexpr int max_units = 1'000;

/** \brief What no query may need more of. */
void
limitQueries(sqlite3* database)
{
  sqlite3_limit(database, SQLITE_LIMIT_LENGTH, static_cast<int>(max_chunk_bytes));
  sqlite3_limit(database, SQLITE_LIMIT_COLUMN, 100);
  sqlite3_limit(database, SQLITE_LIMIT_EXPR_DEPTH, 20);
  sqlite3_limit(database, SQLITE_LIMIT_ATTACHED, 0);
  sqlite3_limit(database, SQLITE_LIMIT_TRIGGER_DEPTH, 1);
  sqlite3_limit(database, SQLITE_LIMIT_WORKER_THREADS, 0);
}

/** \brief Adds the texts that a reader of MCAP knows messages by. */
void
addKnownDefinition(McapChannel& channel)
{
  if (isPointCloud(channel))
    channel.schema = pointCloudChannel(channel.topic).schema;
  else if (isCompressedPointCloud(channel))
    channel.schema = compressedPointCloudChannel(channel.topic).schema;
}

} // namespace

class BagDatabase::Implementation {
public:
  explicit Implementation(const InputFile& file) : file_(file) {}

  ~Implementation()
  {
    sqlite3_blob_close(blob_);
    row_.reset();
    sqlite3_close_v2(database_);
  }

  RecordingStatus
  open(const ChannelFilter& wants, FileContents& contents)
  {
    const std::string& path = file_.file().path();
    const int opened = sqlite3_open_v2(
        "bag", &database_, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, file_.vfsName());
    if (opened != SQLITE_OK)
      return {RecordingCode::InputFailed, "cannot read '" + path + "': " + failure()};
    limitQueries(database_);
    sqlite3_progress_handler(database_, operations_in_unit, countUnit, this);
    sqlite3_db_config(database_, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
    // With an exclusive lock the log needs no shared memory. With a schema that could be
    // written a file that was cut off is read as far as it goes.
    sqlite3_exec(database_,
                 "PRAGMA locking_mode=EXCLUSIVE; PRAGMA trusted_schema=OFF; "
                 "PRAGMA writable_schema=ON; PRAGMA cell_size_check=ON; "
                 "PRAGMA temp_store=MEMORY",
                 nullptr,
                 nullptr,
                 nullptr);
    if (!isBag())
      return {RecordingCode::NotARecording,
              "'" + path + "' is an SQLite file, but no bag of rosbag2 " +
                  (sqlite3_errcode(database_) == SQLITE_OK
                       ? "with tables 'topics' and 'messages'"
                       : "that can be read: " + failure())};
    contents.profile = "ros2";
    contents.sections.emplace_back().is_chunk = false;
    contents.has_end = !file_.hasLog() && !file_.hasJournal();
    if (file_.hasJournal())
      contents.damage.push_back(
          {0, "a write was not completed, and its journal is not used", path});
    findTopics(contents);
    findDefinitions(contents);
    findMessages(wants, contents);
    return {};
  }

  std::string
  read(std::int64_t row, McapMessage& message, std::uint16_t& channel_id)
  {
    if (!row_)
      row_ = std::make_unique<Statement>(
          database_,
          "SELECT rowid, topic_id, timestamp FROM messages WHERE rowid > ?1 LIMIT 1");
    if (stepTo(*row_, row - 1) != Step::Row || row_->number(0) != row)
      return failure();
    const auto topic = channel_of_topic_.find(row_->number(1));
    const std::int64_t time = std::max<std::int64_t>(row_->number(2), 0);
    row_->reset();
    if (topic == channel_of_topic_.end())
      return "it is of no topic";
    channel_id = topic->second;
    message.sequence = 0;
    message.log_time = message.publish_time = Time(time);
    return readBytes(row, message.bytes);
  }

private:
  static int
  countUnit(void* implementation)
  {
    return ++static_cast<Implementation*>(implementation)->units_ > max_units ? 1 : 0;
  }

  std::string
  failure() const
  {
    const int code = sqlite3_errcode(database_);
    return database_ == nullptr ? "SQLite has no memory"
           : code == SQLITE_ROW || code == SQLITE_OK || code == SQLITE_DONE
               ? "its rows contradict each other"
               : sqlite3_errmsg(database_);
  }

  /** \brief Whether the tables are there, and are no views or virtual tables. */
  bool
  isBag()
  {
    Statement tables(database_,
                     "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND "
                     "name IN ('topics', 'messages') AND rootpage > 0");
    return tables.step() == SQLITE_ROW && tables.number(0) == 2;
  }

  void
  findTopics(FileContents& contents)
  {
    Statement topics(database_, "SELECT * FROM topics");
    const int id = topics.isValid() ? topics.columnOf("id") : -1;
    std::size_t bytes = 0;
    int code = SQLITE_ERROR;
    while (id >= 0 && (units_ = 0, code = topics.step()) == SQLITE_ROW) {
      McapChannel channel;
      channel.topic = topics.text(topics.columnOf("name"));
      channel.message_encoding = topics.text(topics.columnOf("serialization_format"));
      channel.schema.name = topics.text(topics.columnOf("type"));
      const std::string qos = topics.text(topics.columnOf(qos_metadata));
      const std::string hash = topics.text(topics.columnOf("type_description_hash"));
      if (!qos.empty())
        channel.metadata[qos_metadata] = qos;
      if (!hash.empty())
        channel.metadata["topic_type_hash"] = hash;
      bytes += channel.topic.size() + channel.message_encoding.size() +
               channel.schema.name.size() + qos.size() + hash.size();
      if (contents.channels.size() == max_topics || bytes > max_topic_bytes) {
        contents.damage.push_back(
            {0, "it has more topics than can be read", file_.file().path()});
        return;
      }
      addKnownDefinition(channel);
      const auto number = static_cast<std::uint16_t>(contents.channels.size());
      if (channel_of_topic_.emplace(topics.number(id), number).second)
        contents.channels.emplace(number, std::move(channel));
    }
    if (code != SQLITE_DONE)
      contents.damage.push_back(
          {0, "its topics cannot be read: " + failure(), file_.file().path()});
  }

  /** \brief Adds the definitions of types, which bags have since Iron. */
  void
  findDefinitions(FileContents& contents)
  {
    Statement definitions(database_,
                          "SELECT topic_type, encoding, encoded_message_definition "
                          "FROM message_definitions");
    std::map<std::string, std::pair<std::string, std::string>> by_type;
    std::size_t bytes = 0;
    while (units_ = 0, definitions.step() == SQLITE_ROW) {
      auto& [encoding, text] = by_type[definitions.text(0)];
      encoding = definitions.text(1);
      text = definitions.text(2);
      if ((bytes += text.size()) > max_definition_bytes)
        return;
    }
    bytes = 0; // many topics may have one type
    for (auto& [id, channel] : contents.channels) {
      const auto found = by_type.find(channel.schema.name);
      if (!channel.schema.text.empty() || found == by_type.end() ||
          found->second.second.empty() || found->second.first == "unknown" ||
          (bytes += found->second.second.size()) > max_definition_bytes)
        continue;
      std::tie(channel.schema.encoding, channel.schema.text) = found->second;
    }
  }

  void
  findMessages(const ChannelFilter& wants, FileContents& contents)
  {
    std::map<std::int64_t, std::uint16_t> wanted;
    for (const auto& [topic, channel] : channel_of_topic_)
      if (!wants || wants(contents.channels[channel]))
        wanted.emplace(topic, channel);
    const std::string& path = file_.file().path();
    Statement rows(database_,
                   "SELECT rowid, topic_id, timestamp FROM messages WHERE rowid > ?1 "
                   "ORDER BY rowid");
    constexpr int max_skips = 256; // each takes up to 126 queries
    int skips = 0;
    std::int64_t last = std::numeric_limits<std::int64_t>::min();
    std::size_t without_topic = 0;
    for (Step step = stepTo(rows, last); step != Step::End;
         step = nextAfter(rows, last)) {
      if (step == Step::Damage) {
        contents.damage.push_back(
            {0,
             (last < 0 ? std::string("messages")
                       : "messages after number " + std::to_string(last)) +
                 " cannot be read: " + failure(),
             path});
        if (++skips > max_skips || !skipDamage(rows, last))
          break;
        continue;
      }
      last = rows.number(0);
      const std::int64_t topic = rows.number(1);
      const std::int64_t time = std::max<std::int64_t>(rows.number(2), 0);
      if (const auto found = wanted.find(topic); found != wanted.end())
        contents.messages.push_back({static_cast<std::uint64_t>(time),
                                     0,
                                     static_cast<std::uint64_t>(last),
                                     found->second});
      else if (channel_of_topic_.count(topic) == 0)
        ++without_topic;
    }
    if (without_topic > 0)
      contents.damage.push_back(
          {0, std::to_string(without_topic) + " messages are of no topic", path});
  }

  enum class Step { Row, End, Damage };

  /** \brief The next row after one. Rows that do not ascend are damage: pages that form a
   * ring would have no end. */
  Step
  nextAfter(Statement& rows, std::int64_t row)
  {
    units_ = 0;
    const int code = rows.step();
    if (code == SQLITE_DONE)
      return Step::End;
    return code == SQLITE_ROW && rows.number(0) > row && rows.isNumber(1) &&
                   rows.isNumber(2)
               ? Step::Row
               : Step::Damage;
  }

  /** \brief Begins anew after a row. */
  Step
  stepTo(Statement& rows, std::int64_t row)
  {
    if (!rows.isValid())
      return Step::Damage;
    rows.bind(row);
    return nextAfter(rows, row);
  }

  /** \brief Goes on after pages that cannot be read.
   * \param[in,out] last row before them; then one after which rows can be read
   * \return false if there is none such
   */
  bool
  skipDamage(Statement& rows, std::int64_t& last)
  {
    const auto isReadable = [&](std::int64_t row) {
      return stepTo(rows, row) != Step::Damage;
    };
    std::int64_t damaged = std::max<std::int64_t>(last, 0); // rows begin at 1
    std::int64_t step = 1;
    while (!isReadable(damaged + step)) {
      damaged += step;
      if (step > (std::numeric_limits<std::int64_t>::max() - damaged) / 2)
        return false;
      step *= 2;
    }
    std::int64_t readable = damaged + step;
    while (readable - damaged > 1) {
      const std::int64_t middle = damaged + (readable - damaged) / 2;
      (isReadable(middle) ? readable : damaged) = middle;
    }
    last = readable;
    rows.bind(last);
    return true;
  }

  std::string
  readBytes(std::int64_t row, std::vector<std::uint8_t>& bytes)
  {
    bytes.clear();
    units_ = 0;
    const int code =
        blob_ != nullptr
            ? sqlite3_blob_reopen(blob_, row)
            : sqlite3_blob_open(database_, "main", "messages", "data", row, 0, &blob_);
    std::string failed = code == SQLITE_OK ? std::string() : failure();
    const auto size =
        static_cast<std::size_t>(code == SQLITE_OK ? sqlite3_blob_bytes(blob_) : 0);
    if (size > file_.file().size() + file_.log().size())
      failed = "it has " + std::to_string(size) + " bytes, which are not there";
    if (failed.empty()) {
      bytes.resize(size);
      if (size > 0 && sqlite3_blob_read(
                          blob_, bytes.data(), static_cast<int>(size), 0) != SQLITE_OK)
        failed = failure();
    }
    if (!failed.empty()) { // it cannot be used again
      bytes.clear();
      sqlite3_blob_close(std::exchange(blob_, nullptr));
    }
    return failed;
  }

  const DatabaseFile file_;
  sqlite3* database_ = nullptr;
  int units_ = 0; // of the query that runs
  std::map<std::int64_t, std::uint16_t> channel_of_topic_;
  std::unique_ptr<Statement> row_;
  sqlite3_blob* blob_ = nullptr;
};

BagDatabase::BagDatabase(InputFile&& file)
: BagFile(std::move(file)), implementation_(new Implementation(this->file()))
{}

BagDatabase::~BagDatabase() = default;

RecordingStatus
BagDatabase::findContents(const ChannelFilter& wants, FileContents& contents)
{
  return implementation_->open(wants, contents);
}

std::string
BagDatabase::read(const MessagePlace& place,
                  McapMessage& message,
                  std::uint16_t& channel_id)
{
  const auto row = static_cast<std::int64_t>(place.offset);
  const std::string failure = implementation_->read(row, message, channel_id);
  return failure.empty() ? failure : "message " + std::to_string(row) + ": " + failure;
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::sqlite
