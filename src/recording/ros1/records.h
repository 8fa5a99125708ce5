// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * The records of bags of ROS 1, version 2.0 of the format
 * (http://wiki.ros.org/Bags/Format/2.0): each has a header of named fields, and data.
 */
#pragma once

#include "recording/bag_contents.h"
#include "recording/files.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

class SpanReader;

namespace ros1 {

/** \brief What bags of all versions that rosbag records begin with, and that of 2.0. */
constexpr char magic[] = "#ROSBAG V";
constexpr char first_line[] = "#ROSBAG V2.0\n";
constexpr std::uint64_t first_line_size = sizeof(first_line) - 1;

enum class Op : std::uint8_t {
  Message = 2,
  BagHeader,
  Index, ///< of the messages of a connection in the chunk before it
  Chunk,
  ChunkInfo,
  Connection
};

/** \brief Fields of a header, in bytes that it does not own. */
class Fields {
public:
  Fields() = default;
  Fields(const std::uint8_t* bytes, std::size_t size) : bytes_(bytes), size_(size) {}

  /** \brief Finds the value of a field.
   * \return false if there is none, or the header is no list of fields before it
   */
  bool
  find(const char* name, std::string& value) const;

  /** \brief A number of as many bytes as asked for; nothing if there is none such. */
  std::optional<std::uint64_t>
  number(const char* name, std::size_t size) const;

  std::optional<Op>
  op() const;

  std::optional<std::uint32_t>
  connection() const;

private:
  const std::uint8_t* bytes_ = nullptr;
  std::size_t size_ = 0;
};

/** \brief Nanoseconds of a time: seconds and nanoseconds of 32 bits each. */
std::uint64_t
nanosecondsOf(std::uint64_t time);

/** \brief A record in memory. */
struct Record {
  Fields fields;
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;
};

/** \brief Takes the next record; false if what follows is none that is whole. */
bool
takeRecord(SpanReader& reader, Record& record);

/** \brief The header of a record of a file, and where its data are. */
class FileRecord {
public:
  /** \brief Reads the header at an offset; false if it is not whole. The data may be
   * cut off. */
  bool
  read(const InputFile& file, std::uint64_t offset);

  const Fields&
  fields() const
  {
    return fields_;
  }

  std::uint64_t
  data() const
  {
    return data_;
  }

  std::uint64_t
  dataSize() const
  {
    return data_size_;
  }

  /** \brief Where the record ends. */
  std::uint64_t
  end() const
  {
    return data_ + data_size_;
  }

private:
  std::vector<std::uint8_t> bytes_; // of the header
  Fields fields_;
  std::uint64_t data_ = 0;
  std::uint64_t data_size_ = 0;
};

/** \brief False for "none"; any other name is that of a compression. */
bool
isCompressed(const std::string& compression);

/** \brief Loads the records of a chunk, as far as they can be read.
 * \param[in] section a chunk; one that is cut off may lack its sizes, too, as those are
 * written when it is complete
 * \param[out] records uncompressed, as many bytes as were decompressed
 * \return empty, or what is wrong
 */
std::string
loadChunk(const InputFile& file,
          const Section& section,
          std::vector<std::uint8_t>& records);

} // namespace ros1
} // namespace pcl_ext::PCL_EXT_ABI::recording
