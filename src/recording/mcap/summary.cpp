// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/mcap/summary.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::recording::mcap {

namespace {

/** \brief Largest summary that is read; a file with a larger one is read as a whole. */
constexpr std::uint64_t max_summary_size = std::uint64_t{1} << 30;

bool
loadSummary(const InputFile& file, std::vector<std::uint8_t>& summary)
{
  const std::uint64_t footer_offset = file.size() - magic.size() - footer_size;
  Footer footer;
  if (!readRecord(file, footer_offset, Opcode::Footer, summary) ||
      !parse(summary.data(), summary.size(), footer) ||
      footer.summary_start < magic.size() || footer.summary_start > footer_offset ||
      footer_offset - footer.summary_start > max_summary_size)
    return false;
  // The checksum covers the footer up to the checksum itself.
  const auto size = static_cast<std::size_t>(footer_offset - footer.summary_start);
  const std::size_t checked_size = size + footer_size - sizeof(std::uint32_t);
  summary.resize(checked_size);
  if (!file.read(footer.summary_start, checked_size, summary.data()) ||
      (footer.summary_checksum != 0 &&
       footer.summary_checksum != checksumOf(summary.data(), checked_size)))
    return false;
  summary.resize(size);
  return true;
}

/** \return false if a record is invalid, or there are no statistics */
bool
parseSummary(const std::vector<std::uint8_t>& bytes,
             ChannelList& channels,
             Summary& summary)
{
  bool has_statistics = false;
  SpanReader reader(bytes.data(), bytes.size());
  Record record;
  while (takeRecord(reader, record)) {
    const auto& [opcode, content, size] = record;
    bool is_valid = true;
    if (opcode == Opcode::Schema)
      channels.addSchema(content, size);
    else if (opcode == Opcode::Channel)
      channels.addChannel(content, size);
    else if (opcode == Opcode::ChunkIndex)
      is_valid = parse(content, size, summary.chunks.emplace_back());
    else if (opcode == Opcode::AttachmentIndex)
      is_valid = parse(content, size, summary.attachments.emplace_back());
    else if (opcode == Opcode::MetadataIndex)
      is_valid = parse(content, size, summary.metadata.emplace_back());
    else if (opcode == Opcode::Statistics) {
      summary.statistics = Statistics();
      is_valid = parse(content, size, summary.statistics);
      has_statistics = true;
    }
    if (!is_valid)
      return false;
  }
  return has_statistics && !reader.failed();
}

/** \brief True if records are where their indexes say, and each has one index. */
bool
areIndexedOnce(const InputFile& file, Opcode opcode, std::vector<RecordExtent> extents)
{
  std::sort(
      extents.begin(), extents.end(), [](const RecordExtent& a, const RecordExtent& b) {
        return a.offset < b.offset;
      });
  std::uint64_t end = 0;
  for (const RecordExtent& extent : extents) {
    Opcode found{};
    std::uint64_t length = 0;
    if (extent.offset < end || extent.length > file.size() ||
        !readRecordPrefix(file, extent.offset, found, length) || found != opcode ||
        length != extent.length - record_prefix_size)
      return false;
    end = extent.offset + extent.length;
  }
  return true;
}

} // namespace

bool
readSummary(const InputFile& file, ChannelList& channels, Summary& summary)
{
  std::vector<std::uint8_t> bytes;
  // Without statistics it is unknown whether the summary tells of all messages.
  return loadSummary(file, bytes) && parseSummary(bytes, channels, summary) &&
         summary.statistics.attachments == summary.attachments.size() &&
         summary.statistics.metadata == summary.metadata.size() &&
         summary.statistics.channels <= channels.size() &&
         areIndexedOnce(file, Opcode::Attachment, summary.attachments) &&
         areIndexedOnce(file, Opcode::Metadata, summary.metadata);
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::mcap
