/** \file
 * \brief Memory of operator new that runs out when a test says so, and how much of it is in
 * use; for programs of any number of threads.
 *
 * \warning Exactly one translation unit per program may include this header: it
 * replaces the global operators.
 */
#pragma once

#include <malloc.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace pcl_ext {
namespace test {

/** \brief Bytes that were taken and not given back. */
inline std::atomic<std::size_t> live_bytes{0};

namespace detail {

inline std::atomic<std::size_t> failing_allocation{0}; ///< 0: none
inline std::atomic<bool> do_later_ones_fail{false};
inline std::atomic<std::size_t> allocations{0}; ///< since one is to fail
inline thread_local bool is_exempt = false;

/** \brief Whether the allocation that is asked for is the one that fails. */
inline bool
isToFail()
{
  const std::size_t failing = failing_allocation;
  if (failing == 0 || is_exempt)
    return false;
  const std::size_t number = ++allocations;
  return number == failing || (do_later_ones_fail && number > failing);
}

} // namespace detail

/** \brief While it lives, one allocation of all threads fails, or all from it on. */
class OneFailingAllocation {
public:
  /** \param[in] number 1 is the next one
   * \param[in] do_later_ones_fail whether those behind it fail, too
   */
  explicit OneFailingAllocation(std::size_t number, bool do_later_ones_fail = false)
  {
    detail::allocations = 0;
    detail::do_later_ones_fail = do_later_ones_fail;
    detail::failing_allocation = number;
  }

  ~OneFailingAllocation() { detail::failing_allocation = 0; }
  OneFailingAllocation(const OneFailingAllocation&) = delete;
  OneFailingAllocation&
  operator=(const OneFailingAllocation&) = delete;

  bool
  hasFailed() const
  {
    return detail::allocations >= detail::failing_allocation;
  }
};

/** \brief While it lives, allocations of its thread neither fail nor count: the test's
 * own. */
class Exemption {
public:
  Exemption() : was_exempt_(detail::is_exempt) { detail::is_exempt = true; }
  ~Exemption() { detail::is_exempt = was_exempt_; }
  Exemption(const Exemption&) = delete;
  Exemption&
  operator=(const Exemption&) = delete;

private:
  bool was_exempt_;
};

} // namespace test
} // namespace pcl_ext

/** \brief Counts what malloc or another function gave. */
inline void*
takenMemory(void* memory)
{
  if (memory == nullptr)
    throw std::bad_alloc();
  pcl_ext::test::live_bytes += malloc_usable_size(memory);
  return memory;
}

// Not inline: GCC would see malloc and delete, or new and free, as a pair.
[[gnu::noinline]] void*
operator new(std::size_t size)
{
  if (pcl_ext::test::detail::isToFail())
    throw std::bad_alloc();
  return takenMemory(std::malloc(size));
}

[[gnu::noinline]] void*
operator new(std::size_t size, std::align_val_t alignment)
{
  if (pcl_ext::test::detail::isToFail())
    throw std::bad_alloc();
  const auto line = static_cast<std::size_t>(alignment);
  return takenMemory(std::aligned_alloc(line, (size + line - 1) / line * line));
}

void*
operator new[](std::size_t size)
{
  return operator new(size);
}

// The standard library's algorithms ask for memory in this way, too. A sanitizer's own
// would give memory that is not for free().
void*
operator new(std::size_t size, const std::nothrow_t& /*unused*/) noexcept
{
  try {
    return operator new(size);
  }
  catch (const std::bad_alloc&) {
    return nullptr;
  }
}

void*
operator new[](std::size_t size, const std::nothrow_t& nothrow) noexcept
{
  return operator new(size, nothrow);
}

[[gnu::noinline]] void
operator delete(void* memory) noexcept
{
  if (memory != nullptr)
    pcl_ext::test::live_bytes -= malloc_usable_size(memory);
  std::free(memory);
}

void
operator delete[](void* memory) noexcept
{
  operator delete(memory);
}

void
operator delete(void* memory, const std::nothrow_t& /*unused*/) noexcept
{
  operator delete(memory);
}

void
operator delete[](void* memory, const std::nothrow_t& /*unused*/) noexcept
{
  operator delete(memory);
}

void
operator delete(void* memory, std::align_val_t) noexcept
{
  operator delete(memory);
}

void
operator delete(void* memory, std::size_t /*size*/, std::align_val_t) noexcept
{
  operator delete(memory);
}

void
operator delete(void* memory, std::size_t /*size*/) noexcept
{
  operator delete(memory);
}

void
operator delete[](void* memory, std::size_t /*size*/) noexcept
{
  operator delete(memory);
}
