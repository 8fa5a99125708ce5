// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/ros1/records.h"

#include "recording/mcap/chunk_compression.h"
#include "recording/span_reader.h"

#include <algorithm>
#include <cstring>

namespace pcl_ext::PCL_EXT_ABI::recording::ros1 {

namespace {

/** \brief The header of a bag has names, numbers and topics only. */
constexpr std::uint32_t max_header_bytes = 1 << 20;

/** \brief Bytes that are read for a header at first. */
constexpr std::size_t usual_header_bytes = 512;

constexpr char not_compressed[] = "none";
constexpr char bz2[] = "bz2";

} // namespace

bool
Fields::find(const char* name, std::string& value) const
{
  const std::size_t name_size = std::strlen(name);
  SpanReader reader(bytes_, size_);
  while (reader.remaining() > 0) {
    const std::uint32_t size = reader.u32();
    const std::uint8_t* const field = reader.take(size);
    if (field == nullptr)
      return false;
    if (size <= name_size || field[name_size] != '=' ||
        !std::equal(field, field + name_size, name))
      continue;
    value.assign(field + name_size + 1, field + size);
    return true;
  }
  return false;
}

std::optional<std::uint64_t>
Fields::number(const char* name, std::size_t size) const
{
  std::string value;
  if (!find(name, value) || value.size() != size)
    return std::nullopt;
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(value.data());
  return SpanReader(bytes, size).number(static_cast<unsigned int>(size));
}

std::optional<Op>
Fields::op() const
{
  const std::optional<std::uint64_t> op = number("op", 1);
  return op ? std::optional<Op>(static_cast<Op>(*op)) : std::nullopt;
}

std::optional<std::uint32_t>
Fields::connection() const
{
  const std::optional<std::uint64_t> connection = number("conn", 4);
  return connection
             ? std::optional<std::uint32_t>(static_cast<std::uint32_t>(*connection))
             : std::nullopt;
}

std::uint64_t
nanosecondsOf(std::uint64_t time)
{
  const std::uint64_t seconds = time & 0xffffffff;
  return seconds * 1'000'000'000 + (time >> 32);
}

bool
takeRecord(SpanReader& reader, Record& record)
{
  const std::uint32_t header_size = reader.u32();
  const std::uint8_t* const header = reader.take(header_size);
  record.size = reader.u32();
  record.data = reader.take(record.size);
  if (record.data == nullptr)
    return false;
  record.fields = {header, header_size};
  return record.fields.op().has_value();
}

bool
FileRecord::read(const InputFile& file, std::uint64_t offset)
{
  constexpr std::uint64_t sizes = 8; // of the two sizes
  if (offset > file.size() || file.size() - offset < sizes)
    return false;
  bytes_.resize(static_cast<std::size_t>(
      std::min<std::uint64_t>(usual_header_bytes, file.size() - offset)));
  if (!file.read(offset, bytes_.size(), bytes_.data()))
    return false;
  const std::uint32_t header_size = SpanReader(bytes_.data(), bytes_.size()).u32();
  if (header_size > max_header_bytes || header_size > file.size() - offset - sizes)
    return false;
  if (bytes_.size() < header_size + sizes) {
    bytes_.resize(header_size + static_cast<std::size_t>(sizes));
    if (!file.read(offset, bytes_.size(), bytes_.data()))
      return false;
  }
  fields_ = {bytes_.data() + 4, header_size};
  data_size_ = SpanReader(bytes_.data() + 4 + header_size, 4).u32();
  data_ = offset + sizes + header_size;
  return true;
}

bool
isCompressed(const std::string& compression)
{
  return compression != not_compressed;
}

std::string
loadChunk(const InputFile& file,
          const Section& section,
          std::vector<std::uint8_t>& records)
{
  records.clear();
  FileRecord chunk;
  std::string compression;
  const bool is_read = chunk.read(file, section.offset);
  const std::optional<std::uint64_t> declared =
      is_read ? chunk.fields().number("size", 4) : std::nullopt;
  const std::uint64_t end = section.offset + section.length;
  if (!declared || chunk.data() > end ||
      !chunk.fields().find("compression", compression))
    return "its fields are invalid; its messages are lost";
  if (compression != bz2 && compression != mcap::lz4_compression &&
      isCompressed(compression))
    return "its compression '" + compression.substr(0, 80) + "' is unknown";
  const std::uint64_t size = end - chunk.data();
  const std::uint64_t most = mostChunkBytes(size);
  if (size > most || *declared > most)
    return largerThan(most) + "; its messages are lost";
  std::vector<std::uint8_t> compressed(static_cast<std::size_t>(size));
  if (!file.read(chunk.data(), compressed.size(), compressed.data()))
    return "it cannot be read; its messages are lost";
  const std::uint64_t max_size = section.is_cut_off ? most : *declared;
  std::string failure =
      compression == bz2
          ? mcap::decompressBz2(compressed.data(), compressed.size(), max_size, records)
          : mcap::decompress(isCompressed(compression) ? compression
                                                       : mcap::no_compression,
                             compressed.data(),
                             compressed.size(),
                             max_size,
                             records);
  if (section.is_cut_off)
    return failure;
  if (failure.empty() && records.size() != *declared)
    failure = "it has fewer bytes than it declares";
  return failure.empty() ? failure : failure + "; its messages are lost";
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::ros1
