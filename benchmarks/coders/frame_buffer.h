// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <streambuf>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief The bytes of one frame between an encoder and a decoder that take streams.
 * Reuses its memory, which std::stringstream does not, so that no allocation of the
 * stream is counted and timed. */
class FrameBuffer : public std::streambuf {
public:
  /** \brief Removes the frame. */
  void
  restart()
  {
    bytes_.clear();
    setg(nullptr, nullptr, nullptr);
  }

  std::size_t
  size() const
  {
    return bytes_.size();
  }

protected:
  int_type
  overflow(int_type byte) override
  {
    if (!traits_type::eq_int_type(byte, traits_type::eof()))
      bytes_.push_back(traits_type::to_char_type(byte));
    return traits_type::not_eof(byte);
  }

  std::streamsize
  xsputn(const char* bytes, std::streamsize count) override
  {
    bytes_.insert(bytes_.end(), bytes, bytes + count);
    return count;
  }

  int_type
  underflow() override
  {
    if (gptr() == nullptr && !bytes_.empty())
      setg(bytes_.data(), bytes_.data(), bytes_.data() + bytes_.size());
    return gptr() == egptr() ? traits_type::eof() : traits_type::to_int_type(*gptr());
  }

private:
  std::vector<char> bytes_;
};

} // namespace measuring
} // namespace pcl_ext
