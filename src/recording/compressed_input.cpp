// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/compressed_input.h"

#include "recording/bag_contents.h"
#include "recording/mcap/chunk_compression.h"
#include "recording/system_files.h"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <functional>
#include <memory>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording {

namespace {

constexpr std::array<std::uint8_t, 4> zstd_magic = {0x28, 0xb5, 0x2f, 0xfd};

/** \brief Decompressed files are at most this large, or this many times their bytes. */
constexpr std::uint64_t least_limit = std::uint64_t{1} << 30;
constexpr std::uint64_t most_expansion = 100;

constexpr std::size_t piece_size = std::size_t{1} << 17;

struct FreeStream {
  void
  operator()(ZSTD_DStream* stream) const
  {
    ZSTD_freeDStream(stream);
  }
};

/** \brief Decompresses a file piece by piece.
 * \param[in] take takes bytes; returns false if it needs no more
 * \return empty, or what is wrong with the compressed bytes
 */
std::string
decompressPieces(
    const InputFile& file,
    const std::function<bool(const std::uint8_t* bytes, std::size_t count)>& take)
{
  const std::unique_ptr<ZSTD_DStream, FreeStream> stream(ZSTD_createDStream());
  if (!stream)
    return "zstd has no memory";
  std::vector<std::uint8_t> input(piece_size);
  std::vector<std::uint8_t> output(piece_size);
  std::size_t expected = 1; // 0 at the end of a frame
  for (std::uint64_t offset = 0; offset < file.size();) {
    const auto count = static_cast<std::size_t>(
        std::min<std::uint64_t>(piece_size, file.size() - offset));
    if (!file.read(offset, count, input.data()))
      return "it cannot be read";
    offset += count;
    ZSTD_inBuffer in{input.data(), count, 0};
    bool is_full = true; // there may be more without any input
    while (in.pos < in.size || is_full) {
      ZSTD_outBuffer out{output.data(), output.size(), 0};
      expected = ZSTD_decompressStream(stream.get(), &out, &in);
      if (ZSTD_isError(expected) != 0)
        return "its compressed bytes are invalid after byte " +
               std::to_string(offset - count + in.pos);
      if (!take(output.data(), out.pos))
        return {};
      is_full = out.pos == out.size;
    }
  }
  return expected == 0 ? std::string() : "it ends within its compressed bytes";
}

/** \brief Bytes of the content of the first frame, as its header has them, or 0. */
std::uint64_t
declaredSize(const InputFile& file)
{
  constexpr std::uint64_t most_header_bytes = 18;
  std::array<std::uint8_t, most_header_bytes> header{};
  const auto count =
      static_cast<std::size_t>(std::min<std::uint64_t>(header.size(), file.size()));
  if (!file.read(0, count, header.data()))
    return 0;
  const std::uint64_t size = ZSTD_getFrameContentSize(header.data(), count);
  return size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR ? 0 : size;
}

RecordingStatus
tooLarge(const InputFile& file, std::uint64_t size)
{
  return {RecordingCode::InputFailed,
          "'" + file.path() + "' has " + std::to_string(size) +
              " bytes or more when it is decompressed: if that is meant, decompress it "
              "with 'zstd -d'"};
}

} // namespace

bool
isZstd(const InputFile& file)
{
  std::array<std::uint8_t, zstd_magic.size()> beginning{};
  return file.read(0, beginning.size(), beginning.data()) && beginning == zstd_magic;
}

RecordingStatus
decompressFile(InputFile& file, std::string& damage)
{
  TemporaryFile copy;
  if (!copy.create())
    return noTemporaryFile(file.path());
  const std::uint64_t limit = std::max(least_limit, most_expansion * file.size());
  std::uint64_t size = 0;
  if (const std::uint64_t declared = declaredSize(file); declared > limit)
    return tooLarge(file, declared);
  int error = 0;
  damage = decompressPieces(file, [&](const std::uint8_t* bytes, std::size_t count) {
    size += count;
    if (size <= limit && !writeAll(copy.descriptor(), bytes, count))
      error = errno;
    return size <= limit && error == 0;
  });
  if (error != 0)
    return {RecordingCode::InputFailed,
            "cannot decompress '" + file.path() + "' into a temporary file: " +
                std::strerror(error) + "; name a folder with room for it in TMPDIR"};
  if (size > limit)
    return tooLarge(file, size);
  return file.replaceBy(std::move(copy));
}

std::vector<std::uint8_t>
beginningOf(const InputFile& file, std::size_t count)
{
  std::vector<std::uint8_t> beginning;
  if (isZstd(file)) {
    decompressPieces(file, [&](const std::uint8_t* bytes, std::size_t more) {
      beginning.insert(beginning.end(), bytes, bytes + more);
      return beginning.size() < count;
    });
    beginning.resize(std::min(beginning.size(), count));
    return beginning;
  }
  beginning.resize(
      static_cast<std::size_t>(std::min<std::uint64_t>(count, file.size())));
  if (!file.read(0, beginning.size(), beginning.data()))
    beginning.clear();
  return beginning;
}

std::string
decompressMessage(const McapChannel& channel, std::vector<std::uint8_t>& bytes)
{
  // CDR begins with 0.
  if (channel.message_encoding != "cdr" || bytes.size() < zstd_magic.size() ||
      !std::equal(zstd_magic.begin(), zstd_magic.end(), bytes.begin()))
    return {};
  if (ZSTD_findFrameCompressedSize(bytes.data(), bytes.size()) != bytes.size())
    return "the compressed bytes of a message are not whole";
  std::vector<std::uint8_t> message;
  const std::uint64_t most = std::max(max_chunk_bytes, mostChunkBytes(bytes.size()));
  // One more, as a message does not declare its bytes.
  std::string failure = mcap::decompress(
      mcap::zstd_compression, bytes.data(), bytes.size(), most + 1, message);
  if (message.size() > most)
    failure = largerThan(most);
  bytes.swap(message);
  return failure.empty() ? failure : "a compressed message: " + failure;
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
