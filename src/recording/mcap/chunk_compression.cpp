// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/mcap/chunk_compression.h"

#ifdef PCL_EXT_HAS_BZIP2
#include <bzlib.h>
#endif
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

namespace pcl_ext::PCL_EXT_ABI::recording::mcap {

namespace {

constexpr std::size_t piece_size = std::size_t{1} << 17;
// Compresses maps, poses and images a little better than lz4 in about the same time.
constexpr int zstd_level = 1;

struct FreeZstd {
  void
  operator()(ZSTD_DStream* stream) const
  {
    ZSTD_freeDStream(stream);
  }
};

struct FreeLz4 {
  void
  operator()(LZ4F_dctx* context) const
  {
    LZ4F_freeDecompressionContext(context);
  }
};

/** \brief Decompresses pieces until the input or the room for the output ends.
 * \param[in] step takes the output of a piece, its size, the input and its size; sets
 * both sizes to what it used; returns false if the bytes are invalid
 */
template <typename StepT>
std::string
decompressPieces(const std::uint8_t* bytes,
                 std::size_t size,
                 std::uint64_t max_size,
                 std::vector<std::uint8_t>& records,
                 StepT step)
{
  std::size_t used = 0;
  bool is_full = true;
  // A full piece of output may have more after it without any input.
  while (used < size || is_full) {
    const std::size_t begin = records.size();
    // One byte more than there may be, to notice that there are more.
    const auto room = static_cast<std::size_t>(
        std::min<std::uint64_t>(piece_size, max_size - begin + 1));
    records.resize(begin + room);
    std::size_t read = size - used;
    std::size_t written = room;
    const bool is_valid = step(records.data() + begin, written, bytes + used, read);
    records.resize(begin + written);
    if (!is_valid)
      return "its compressed bytes are invalid";
    if (records.size() > max_size) {
      records.resize(static_cast<std::size_t>(max_size));
      return "it has more bytes than it declares";
    }
    if (read == 0 && written == 0)
      break;
    used += read;
    is_full = written == room;
  }
  return {};
}

std::string
decompressZstd(const std::uint8_t* bytes,
               std::size_t size,
               std::uint64_t max_size,
               std::vector<std::uint8_t>& records)
{
  const std::unique_ptr<ZSTD_DStream, FreeZstd> stream(ZSTD_createDStream());
  if (!stream)
    return "zstd has no memory";
  return decompressPieces(bytes,
                          size,
                          max_size,
                          records,
                          [&](std::uint8_t* output,
                              std::size_t& output_size,
                              const std::uint8_t* input,
                              std::size_t& input_size) {
                            ZSTD_outBuffer out{output, output_size, 0};
                            ZSTD_inBuffer in{input, input_size, 0};
                            const std::size_t result =
                                ZSTD_decompressStream(stream.get(), &out, &in);
                            output_size = out.pos;
                            input_size = in.pos;
                            return ZSTD_isError(result) == 0;
                          });
}

std::string
decompressLz4(const std::uint8_t* bytes,
              std::size_t size,
              std::uint64_t max_size,
              std::vector<std::uint8_t>& records)
{
  LZ4F_dctx* created = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&created, LZ4F_VERSION)) != 0)
    return "lz4 has no memory";
  const std::unique_ptr<LZ4F_dctx, FreeLz4> context(created);
  return decompressPieces(
      bytes,
      size,
      max_size,
      records,
      [&](std::uint8_t* output,
          std::size_t& output_size,
          const std::uint8_t* input,
          std::size_t& input_size) {
        const std::size_t result = LZ4F_decompress(
            context.get(), output, &output_size, input, &input_size, nullptr);
        const bool is_valid = LZ4F_isError(result) == 0;
        output_size = is_valid ? output_size : 0;
        return is_valid;
      });
}

#ifdef PCL_EXT_HAS_BZIP2
/** \brief A stream of libbz2, which ends with the stream's last byte. */
class Bz2Stream {
public:
  Bz2Stream() : is_valid_(BZ2_bzDecompressInit(&stream_, 0, 0) == BZ_OK) {}
  ~Bz2Stream() { BZ2_bzDecompressEnd(&stream_); }
  Bz2Stream(const Bz2Stream&) = delete;
  Bz2Stream&
  operator=(const Bz2Stream&) = delete;

  bool
  step(std::uint8_t* output,
       std::size_t& output_size,
       const std::uint8_t* input,
       std::size_t& input_size)
  {
    stream_.next_in = reinterpret_cast<char*>(const_cast<std::uint8_t*>(input));
    stream_.avail_in = static_cast<unsigned int>(input_size);
    stream_.next_out = reinterpret_cast<char*>(output);
    stream_.avail_out = static_cast<unsigned int>(output_size);
    if (is_valid_ && !has_ended_) {
      const int result = BZ2_bzDecompress(&stream_);
      has_ended_ = result == BZ_STREAM_END;
      is_valid_ = has_ended_ || result == BZ_OK;
    }
    output_size -= stream_.avail_out;
    input_size -= stream_.avail_in;
    return is_valid_;
  }

private:
  bz_stream stream_{};
  bool is_valid_;
  bool has_ended_ = false;
};
#endif

} // namespace

std::string
decompress(const std::string& compression,
           const std::uint8_t* bytes,
           std::size_t size,
           std::uint64_t max_size,
           std::vector<std::uint8_t>& records)
{
  records.clear();
  if (compression == zstd_compression)
    return decompressZstd(bytes, size, max_size, records);
  if (compression == lz4_compression)
    return decompressLz4(bytes, size, max_size, records);
  if (compression != no_compression)
    return "its compression '" + compression.substr(0, 80) + "' is unknown";
  if (size > max_size)
    return "it has more bytes than it declares";
  records.assign(bytes, bytes + size);
  return {};
}

#ifdef PCL_EXT_HAS_BZIP2
std::string
decompressBz2(const std::uint8_t* bytes,
              std::size_t size,
              std::uint64_t max_size,
              std::vector<std::uint8_t>& records)
{
  records.clear();
  Bz2Stream stream;
  return decompressPieces(bytes,
                          size,
                          max_size,
                          records,
                          [&](std::uint8_t* output,
                              std::size_t& output_size,
                              const std::uint8_t* input,
                              std::size_t& input_size) {
                            return stream.step(output, output_size, input, input_size);
                          });
}
#else
std::string
decompressBz2(const std::uint8_t* /* bytes */,
              std::size_t /* size */,
              std::uint64_t /* max_size */,
              std::vector<std::uint8_t>& records)
{
  records.clear();
  return "it is compressed with bz2, and this program was built without libbz2: copy "
         "the bag with 'rosbag decompress', or build where libbz2-dev is installed";
}
#endif

bool
compress(const std::vector<std::uint8_t>& records, std::vector<std::uint8_t>& bytes)
{
  bytes.resize(ZSTD_compressBound(records.size()));
  const std::size_t size = ZSTD_compress(
      bytes.data(), bytes.size(), records.data(), records.size(), zstd_level);
  if (ZSTD_isError(size) != 0)
    return false;
  bytes.resize(size);
  return size < records.size();
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::mcap
