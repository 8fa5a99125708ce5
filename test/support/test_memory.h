/** \file
 * \brief What a test can ask of operator new: how much was taken, that it fails, and that
 * nothing behind a block can be read. Without one of these objects it is plain malloc.
 *
 * Needs support/test_memory.cpp, which replaces the global operators.
 */
#pragma once

#include <cstddef>

namespace pcl_ext {
namespace test {

/** \brief Counts what all threads take from operator new while it lives.
 *
 * A second object begins all counts anew but that of the live bytes.
 */
class MemoryUse {
public:
  MemoryUse();
  ~MemoryUse();
  MemoryUse(const MemoryUse&) = delete;
  MemoryUse&
  operator=(const MemoryUse&) = delete;

  std::size_t
  allocations() const;

  /** \brief Bytes of the largest allocation. */
  std::size_t
  largest() const;

  /** \brief Bytes taken and not given back; 0 if more was given back than taken. */
  std::size_t
  live() const;

  /** \brief The most that live() was. */
  std::size_t
  peak() const;

private:
  std::ptrdiff_t before_;
};

/** \brief While it lives, one allocation of all threads fails, or all from it on. */
class FailingAllocation {
public:
  /** \param[in] number 1 is the next one
   * \param[in] do_later_ones_fail whether all behind it fail, too
   */
  explicit FailingAllocation(std::size_t number, bool do_later_ones_fail = false);
  ~FailingAllocation();
  FailingAllocation(const FailingAllocation&) = delete;
  FailingAllocation&
  operator=(const FailingAllocation&) = delete;

  bool
  hasFailed() const;
};

/** \brief While it lives, allocations of its thread neither fail nor count for
 * FailingAllocation: those of the test itself. */
class Exemption {
public:
  Exemption();
  ~Exemption();
  Exemption(const Exemption&) = delete;
  Exemption&
  operator=(const Exemption&) = delete;

private:
  bool was_exempt_;
};

/** \brief While it lives, blocks end at a page that cannot be read: a read behind a
 * vector ends the program, without a sanitizer, too. For tests of one thread. */
class FencedMemory {
public:
  FencedMemory();
  ~FencedMemory();
  FencedMemory(const FencedMemory&) = delete;
  FencedMemory&
  operator=(const FencedMemory&) = delete;
};

} // namespace test
} // namespace pcl_ext
