#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <streambuf>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Reads numbers, little-endian, from a stream buffer; never behind its end and
 * never more bytes than allowed.
 *
 * Errors stick: after the first failed read every read gives zeros, so that a parser
 * can read on and look at failure() once.
 */
class ByteSource {
public:
  enum class Failure {
    None,
    EndOfInput,   ///< the stream ended
    LimitExceeded ///< the allowed number of bytes is used up
  };

  /** \brief Reads from a buffer.
   * \param[in] buffer where to read
   * \param[in] max_bytes bytes that may be read at most
   */
  ByteSource(std::streambuf& buffer, std::size_t max_bytes)
  : buffer_(buffer), remaining_(max_bytes)
  {}

  std::uint8_t
  u8()
  {
    if (remaining_ == 0)
      fail(Failure::LimitExceeded);
    if (failure_ != Failure::None)
      return 0;
    const auto byte = buffer_.sbumpc();
    if (byte == std::streambuf::traits_type::eof()) {
      fail(Failure::EndOfInput);
      return 0;
    }
    --remaining_;
    ++consumed_;
    const auto number =
        static_cast<std::uint8_t>(std::streambuf::traits_type::to_char_type(byte));
    if (record_ != nullptr)
      record_->push_back(number);
    return number;
  }

  std::uint16_t
  u16()
  {
    return static_cast<std::uint16_t>(littleEndian(2));
  }

  std::uint32_t
  u32()
  {
    return static_cast<std::uint32_t>(littleEndian(4));
  }

  std::int32_t
  i32()
  {
    return static_cast<std::int32_t>(u32());
  }

  std::uint64_t
  u64()
  {
    return littleEndian(8);
  }

  float
  f32()
  {
    const std::uint32_t bits = u32();
    float number;
    std::memcpy(&number, &bits, sizeof(number));
    return number;
  }

  double
  f64()
  {
    const std::uint64_t bits = u64();
    double number;
    std::memcpy(&number, &bits, sizeof(number));
    return number;
  }

  /** \brief Counterpart of ByteWriter::varint; at most 10 bytes, of which the last
   * holds the highest bit. A longer one, or one with a needless last byte, reads as the
   * largest number, which no field allows. */
  std::uint64_t
  varint();

  /** \brief Counterpart of ByteWriter::signedVarint; what is no varint reads as the
   * smallest number, which no field allows. */
  std::int64_t
  signedVarint()
  {
    const std::uint64_t bits = varint();
    return static_cast<std::int64_t>((bits & 1) != 0 ? ~(bits >> 1) : bits >> 1);
  }

  /** \brief Appends bytes to a vector; its memory grows with what really arrives, not
   * with what was asked for. Many bytes are not read at all where the buffer can tell that
   * it ends before them. */
  void
  read(std::size_t size, std::vector<std::uint8_t>& bytes);

  /** \brief Passes bytes over, without reading them where the buffer can seek. */
  void
  skip(std::size_t size);

  /** \brief Bytes that were passed over without being read. */
  std::size_t
  skipped() const
  {
    return skipped_;
  }

  /** \brief From now on, appends every byte that is read to a vector; null stops it. */
  void
  recordTo(std::vector<std::uint8_t>* bytes)
  {
    record_ = bytes;
  }

  /** \brief Why a read failed, if one did. */
  Failure
  failure() const
  {
    return failure_;
  }

  /** \brief Bytes read or passed over so far. */
  std::size_t
  consumed() const
  {
    return consumed_;
  }

private:
  /** \brief False if the buffer can seek and ends before so many bytes. */
  bool
  mayHold(std::size_t size);

  bool
  seekForward(std::size_t size);

  void
  fail(Failure failure)
  {
    if (failure_ == Failure::None)
      failure_ = failure;
  }

  std::uint64_t
  littleEndian(unsigned int size)
  {
    std::uint64_t number = 0;
    for (unsigned int i = 0; i < size; ++i)
      number |= static_cast<std::uint64_t>(u8()) << (8 * i);
    return number;
  }

  std::streambuf& buffer_;
  std::size_t remaining_;
  std::size_t consumed_ = 0;
  std::size_t skipped_ = 0;
  Failure failure_ = Failure::None;
  std::vector<std::uint8_t>* record_ = nullptr;
};

} // namespace io
} // namespace pcl_ext
