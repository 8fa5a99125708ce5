// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/version.h>

#include <cstddef>
#include <functional>
#include <memory>

namespace pcl_ext {
namespace io {

/** \brief Memory that the decoders of a program share: what they keep from frame to
 * frame. Where that is more, what was used the longest ago is dropped. A decoder whose
 * history was dropped answers P-frames with MissingReference and its reason, and
 * continues with an I-frame. Decoders get it by DecoderLimits::budget. Thread-safe.
 *
 * Beside it are the memory of the frames that are being decoded, and what the program
 * keeps of them.
 * \code
 * pcl_ext::io::DecoderLimits limits;
 * limits.budget = std::make_shared<pcl_ext::io::MemoryBudget>(std::size_t{1} << 30);
 * pcl_ext::io::FrameDecoder first(limits), second(limits);
 * \endcode
 */
class PCL_EXT_CODEC_EXPORT MemoryBudget {
public:
  /** \param[in] bytes that may be kept; 0: a quarter of machineBytes(), as frames in work
   * may take as much once more, and merging them likewise */
  explicit MemoryBudget(std::size_t bytes = 0);
  ~MemoryBudget();
  MemoryBudget(const MemoryBudget&) = delete;
  MemoryBudget&
  operator=(const MemoryBudget&) = delete;

  /** \brief Bytes that may be kept. */
  std::size_t
  limit() const;

  /** \brief Bytes that are kept, an estimate that is rather too high. */
  std::size_t
  used() const;

  /** \brief How often something was dropped. */
  std::size_t
  drops() const;

  /** \brief Memory of the machine, bytes, or of the control group of a Linux container if
   * that is less; 4 GiB where it is not known. */
  static std::size_t
  machineBytes();

private:
  friend class MemoryShare;
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

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

} // namespace io
} // namespace pcl_ext
