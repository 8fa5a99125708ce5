// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "bytes/byte_source.h"
#include "bytes/byte_writer.h"
#include "codec/scan/plane.h"
#include "codec/scan/symbol_coding.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

/** \brief Appends planes: of each the size in bytes, and its stream of symbols. */
class PlaneWriter {
public:
  static constexpr bool is_decoder = false;

  PlaneWriter(SymbolWorkspace& work,
              std::vector<std::uint8_t>& plane,
              std::vector<std::uint8_t>& bytes)
  : work_(work), plane_(plane), bytes_(bytes)
  {}

  /** \brief Codes a byte of 0 or 1. */
  bool
  codeFlag(bool& flag)
  {
    bytes_.push_back(flag ? 1 : 0);
    return true;
  }

  /** \brief Codes a plane.
   * \param[in] code called as code(coding)
   * \param[in] contexts of its symbols
   */
  template <class CodeT>
  bool
  codePlane(const CodeT& code, std::size_t contexts = plane_contexts)
  {
    SymbolEncoding coding(work_);
    code(coding);
    plane_.clear();
    coding.finish(contexts, plane_);
    ByteWriter(bytes_).varint(plane_.size());
    bytes_.insert(bytes_.end(), plane_.begin(), plane_.end());
    return true;
  }

private:
  SymbolWorkspace& work_;
  std::vector<std::uint8_t>& plane_;
  std::vector<std::uint8_t>& bytes_;
};

/** \brief Reads what PlaneWriter wrote. */
class PlaneReader {
public:
  static constexpr bool is_decoder = true;

  PlaneReader(SymbolWorkspace& work, const std::uint8_t* begin, const std::uint8_t* end)
  : work_(work), next_(begin), end_(end)
  {}

  bool
  codeFlag(bool& flag)
  {
    if (isAtEnd() || *next_ > 1)
      return false;
    flag = *next_++ != 0;
    return true;
  }

  template <class CodeT>
  bool
  codePlane(const CodeT& code, std::size_t contexts = plane_contexts)
  {
    const auto left = static_cast<std::size_t>(end_ - next_);
    MemoryBuffer buffer(next_, left);
    ByteSource source(buffer, left);
    const std::uint64_t size = source.varint();
    if (source.failure() != ByteSource::Failure::None ||
        size > left - source.consumed())
      return false;
    next_ += source.consumed();
    SymbolDecoding coding(next_, next_ + size, contexts, work_);
    next_ += size;
    return coding.hasTables() && code(coding) && coding.isAtEnd();
  }

  /** \brief The first byte that was not read. */
  const std::uint8_t*
  next() const
  {
    return next_;
  }

  bool
  isAtEnd() const
  {
    return next_ == end_;
  }

private:
  SymbolWorkspace& work_;
  const std::uint8_t* next_;
  const std::uint8_t* end_;
};

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io
