// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What a test can ask of operator new: how much was taken, and that it fails.
 * Without one of these objects it is plain malloc.
 *
 * Needs support/test_memory.cpp, which replaces the global operators.
 */
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <new>

namespace pcl_ext::test {

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
  /** \param[in] number 1 is the next one; 0: none fails
   * \param[in] do_later_ones_fail whether all after it fail, too
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

/** \brief Has each allocation of each frame of a stream fail alone, and every third one
 * with all later ones.
 * \param[in] run called with a frame, the number of the allocation, and whether later
 * ones fail, too; false if the frame has fewer allocations
 */
template <typename RunT>
void
expectFailuresHandled(std::size_t frame_count, const RunT& run)
{
  std::size_t failures = 0;
  for (const bool do_later_ones_fail : {false, true})
    for (std::size_t frame = 0; frame < frame_count; ++frame)
      for (std::size_t n = 1; run(frame, n, do_later_ones_fail);
           n += do_later_ones_fail ? 3 : 1) {
        ++failures;
        if (::testing::Test::HasFailure())
          FAIL() << "allocation " << n << " of frame " << frame;
      }
  EXPECT_GT(failures, 50u);
}

/** \brief Repeats a call, of which first the first allocation fails, then the second,
 * until none does. It must throw std::bad_alloc where one fails.
 * \param[in] check called after each failure
 * \return number of failures
 */
template <typename CallT, typename CheckT>
std::size_t
failEachAllocation(const CallT& call, const CheckT& check)
{
  for (std::size_t number = 1;; ++number) {
    bool has_failed = false;
    {
      const FailingAllocation failing(number);
      bool has_thrown = false;
      try {
        call();
      }
      catch (const std::bad_alloc&) {
        has_thrown = true;
      }
      const Exemption exemption;
      has_failed = failing.hasFailed();
      EXPECT_EQ(has_thrown, has_failed);
    }
    if (!has_failed)
      return number - 1;
    check();
  }
}

template <typename CallT>
std::size_t
failEachAllocation(const CallT& call)
{
  return failEachAllocation(call, [] {});
}

} // namespace pcl_ext::test
