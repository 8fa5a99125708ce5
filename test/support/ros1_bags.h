// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Bags of ROS 1 (http://wiki.ros.org/Bags/Format/2.0), for tests.
 */
#pragma once

#ifdef PCL_EXT_HAS_BZIP2
#include <pcl_ext/version.h>

#include <bzlib.h>
#endif
#include <lz4frame.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

inline std::string
littleEndian(std::uint64_t number, std::size_t size)
{
  std::string bytes;
  for (std::size_t i = 0; i < size; ++i)
    bytes.push_back(static_cast<char>(number >> 8 * i));
  return bytes;
}

/** \brief A time as bags have it: seconds and nanoseconds. */
inline std::string
ros1Time(std::uint64_t nanoseconds)
{
  return littleEndian(nanoseconds / 1'000'000'000, 4) +
         littleEndian(nanoseconds % 1'000'000'000, 4);
}

inline std::string
sized(const std::string& bytes)
{
  return littleEndian(bytes.size(), 4) + bytes;
}

inline std::string
ros1Fields(const std::vector<std::pair<std::string, std::string>>& fields)
{
  std::string bytes;
  for (const auto& [name, value] : fields)
    bytes += sized(name + "=" + value);
  return bytes;
}

inline std::string
ros1Record(char op,
           std::vector<std::pair<std::string, std::string>> fields,
           const std::string& data)
{
  fields.emplace_back("op", std::string(1, op));
  return sized(ros1Fields(fields)) + sized(data);
}

inline std::string
compressedChunk(const std::string& compression, const std::string& records)
{
  if (compression == "lz4") {
    LZ4F_preferences_t preferences{};
    preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
    std::string bytes(LZ4F_compressFrameBound(records.size(), &preferences), '\0');
    bytes.resize(LZ4F_compressFrame(
        bytes.data(), bytes.size(), records.data(), records.size(), &preferences));
    return bytes;
  }
#ifdef PCL_EXT_HAS_BZIP2
  if (compression == "bz2") {
    auto size = static_cast<unsigned int>(records.size() + records.size() / 50 + 700);
    std::string bytes(size, '\0');
    if (BZ2_bzBuffToBuffCompress(bytes.data(),
                                 &size,
                                 const_cast<char*>(records.data()),
                                 static_cast<unsigned int>(records.size()),
                                 9,
                                 0,
                                 0) != BZ_OK)
      throw std::runtime_error("bz2 failed");
    bytes.resize(size);
    return bytes;
  }
#endif
  if (compression != "none")
    throw std::runtime_error("compression '" + compression + "' is unknown");
  return records;
}

/** \brief Writes a bag as rosbag does: chunks, each with indexes behind it; at the end
 * connections and the places of the chunks. */
class Ros1Bag {
public:
  explicit Ros1Bag(const std::string& compression = "none") : compression_(compression)
  {}

  bool has_indexes = true;     ///< behind chunks
  bool has_connections = true; ///< at the end
  std::size_t padding = 4000; ///< bytes behind the header, for what is known at the end

  void
  addConnection(std::uint32_t id,
                const std::string& topic,
                const std::string& type,
                const std::string& definition = "",
                const std::string& caller = "/node")
  {
    const std::string record =
        ros1Record(7,
                   {{"conn", littleEndian(id, 4)}, {"topic", topic}},
                   ros1Fields({{"topic", topic},
                               {"type", type},
                               {"md5sum", "0123456789abcdef0123456789abcdef"},
                               {"message_definition", definition},
                               {"callerid", caller}}));
    connections_ += record;
    chunk_ += record;
  }

  void
  addMessage(std::uint32_t id,
             std::uint64_t nanoseconds,
             const std::vector<std::uint8_t>& bytes)
  {
    index_[id] += ros1Time(nanoseconds) + littleEndian(chunk_.size(), 4);
    chunk_ +=
        ros1Record(2,
                   {{"conn", littleEndian(id, 4)}, {"time", ros1Time(nanoseconds)}},
                   {bytes.begin(), bytes.end()});
  }

  void
  endChunk()
  {
    addChunk(compressedChunk(compression_, chunk_), chunk_.size());
  }

  /** \brief Adds the chunk with other bytes or another size than it has. */
  void
  addChunk(const std::string& bytes, std::uint64_t size)
  {
    infos_ += ros1Record(6,
                         {{"ver", littleEndian(1, 4)},
                          {"chunk_pos", littleEndian(begin() + chunks_.size(), 8)},
                          {"start_time", ros1Time(0)},
                          {"end_time", ros1Time(0)},
                          {"count", littleEndian(0, 4)}},
                         "");
    chunks_ += ros1Record(
        5, {{"compression", compression_}, {"size", littleEndian(size, 4)}}, bytes);
    if (has_indexes)
      for (const auto& [id, entries] : index_)
        chunks_ += ros1Record(4,
                              {{"ver", littleEndian(1, 4)},
                               {"conn", littleEndian(id, 4)},
                               {"count", littleEndian(entries.size() / 12, 4)}},
                              entries);
    index_.clear();
    chunk_.clear();
  }

  void
  add(const std::string& bytes)
  {
    chunks_ += bytes;
  }

  /** \brief The bag when the recorder has closed it. */
  std::vector<std::uint8_t>
  bytes() const
  {
    const std::string all = header(begin() + chunks_.size()) + chunks_ +
                            (has_connections ? connections_ : "") + infos_;
    return {all.begin(), all.end()};
  }

  /** \brief The bag while it is recorded: without an index, and the last chunk without
   * its sizes. */
  std::vector<std::uint8_t>
  unfinishedBytes() const
  {
    const std::string all =
        header(0) + chunks_ +
        ros1Record(
            5, {{"compression", compression_}, {"size", littleEndian(0, 4)}}, "") +
        compressedChunk(compression_, chunk_);
    return {all.begin(), all.end()};
  }

  std::size_t
  begin() const
  {
    return header(0).size();
  }

  /** \brief Bytes of the chunks that are complete. */
  std::size_t
  size() const
  {
    return begin() + chunks_.size();
  }

private:
  std::string
  header(std::uint64_t index) const
  {
    const std::vector<std::pair<std::string, std::string>> fields = {
        {"index_pos", littleEndian(index, 8)},
        {"conn_count", littleEndian(0, 4)},
        {"chunk_count", littleEndian(0, 4)}};
    return "#ROSBAG V2.0\n" + ros1Record(3, fields, std::string(padding, ' '));
  }

  std::string compression_;
  std::string chunk_;
  std::map<std::uint32_t, std::string> index_; // entries by connection
  std::string chunks_;
  std::string connections_;
  std::string infos_;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording::test
