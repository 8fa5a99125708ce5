// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/decoder_limits.h>
#include <pcl_ext/export.h>

#include <cstddef>
#include <functional>
#include <memory>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief What one user of a MemoryBudget keeps, as a decoder its history. */
class PCL_EXT_CODEC_EXPORT MemoryShare {
public:
  /** \param[in] budget none: nothing is ever dropped
   * \param[in] drop releases the memory. It is called by any thread that uses the budget,
   * but not between begin() and end(), and must neither throw nor use the budget.
   */
  MemoryShare(std::shared_ptr<MemoryBudget> budget, std::function<void()> drop);
  ~MemoryShare();
  MemoryShare(const MemoryShare&) = delete;
  MemoryShare&
  operator=(const MemoryShare&) = delete;

  /** \brief The memory is used from here on. */
  void
  begin() noexcept;

  /** \brief The memory is used no more. Drops what is too much, this last.
   * \param[in] bytes that are kept
   */
  void
  end(std::size_t bytes) noexcept;

private:
  struct Entry;
  friend class MemoryBudget;
  std::shared_ptr<MemoryBudget> budget_;
  std::unique_ptr<Entry> entry_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
