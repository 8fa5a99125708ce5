#pragma once

#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Appends bits to bytes, the first bit in the highest place of a byte. */
class BitWriter {
public:
  explicit BitWriter(std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}

  /** \brief Writes the low bits of a number, the highest of them first. */
  void
  write(std::uint32_t number, unsigned int count)
  {
    while (count-- > 0) {
      partial_ = static_cast<std::uint8_t>(partial_ * 2u + ((number >> count) & 1u));
      if (++partial_count_ == 8) {
        bytes_.push_back(partial_);
        partial_count_ = 0;
      }
    }
  }

  /** \brief Elias gamma code of a number above 0: as many zeros as bits follow the
   * highest one, then the number. */
  void
  gamma(std::uint32_t number)
  {
    unsigned int length = 0;
    while (number >> (length + 1) != 0)
      ++length;
    write(0, length);
    write(number, length + 1);
  }

  /** \brief Fills the last byte with zeros. */
  void
  flush()
  {
    if (partial_count_ != 0)
      write(0, 8 - partial_count_);
  }

private:
  std::vector<std::uint8_t>& bytes_;
  std::uint8_t partial_ = 0;
  unsigned int partial_count_ = 0;
};

/** \brief Counterpart of BitWriter over bytes in memory. */
class BitReader {
public:
  BitReader(const std::uint8_t* begin, const std::uint8_t* end)
  : position_(begin), end_(end)
  {}

  /** \brief A gamma code; 0, which no code stands for, if the bytes end or the number
   * has more than 16 bits. */
  std::uint32_t
  gamma()
  {
    unsigned int length = 0;
    while (next() == 0)
      if (!good_ || ++length > 15)
        return 0;
    std::uint32_t number = 1;
    for (; length > 0; --length)
      number = number << 1 | next();
    return good_ ? number : 0;
  }

  /** \brief The first byte of which no bit was read. */
  const std::uint8_t*
  position() const
  {
    return position_;
  }

private:
  std::uint32_t
  next()
  {
    if (remaining_ == 0) {
      if (position_ == end_) {
        good_ = false;
        return 0;
      }
      partial_ = *position_++;
      remaining_ = 8;
    }
    return (partial_ >> --remaining_) & 1u;
  }

  const std::uint8_t* position_;
  const std::uint8_t* end_;
  std::uint8_t partial_ = 0;
  unsigned int remaining_ = 0;
  bool good_ = true;
};

} // namespace io
} // namespace pcl_ext
