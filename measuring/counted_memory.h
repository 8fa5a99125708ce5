/** \file
 * \brief Counts the memory that a program takes from operator new.
 *
 * \warning Exactly one translation unit per program may include this header: it
 * replaces the global operators.
 */
#pragma once

#include <malloc.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace pcl_ext {
namespace io {
namespace test {

/** \brief Bytes since the last reset; programs of one thread only. */
struct MemoryCount {
  /** \brief Off: allocations are counted and nothing else, which costs no time worth
   * mentioning, so that a benchmark can look at both. */
  bool counts_bytes = true;

  std::size_t allocations = 0; ///< since the last reset
  std::size_t largest = 0;     ///< of one allocation
  std::size_t live = 0;        ///< allocated and not yet given back
  std::size_t peak = 0;        ///< the most that was live

  void
  reset()
  {
    allocations = 0;
    largest = 0;
    peak = live;
  }
};

inline MemoryCount memory_count;

} // namespace test
} // namespace io
} // namespace pcl_ext

/** \brief Counts what malloc or another function gave. */
inline void*
countedMemory(void* memory, std::size_t size)
{
  auto& count = pcl_ext::io::test::memory_count;
  if (memory == nullptr)
    throw std::bad_alloc();
  ++count.allocations;
  if (!count.counts_bytes)
    return memory;
  count.largest = std::max(count.largest, size);
  count.live += malloc_usable_size(memory);
  count.peak = std::max(count.peak, count.live);
  return memory;
}

// Not inline: GCC would see malloc and delete, or new and free, as a pair.
[[gnu::noinline]] void*
operator new(std::size_t size)
{
  return countedMemory(std::malloc(size), size);
}

[[gnu::noinline]] void*
operator new(std::size_t size, std::align_val_t alignment)
{
  const auto line = static_cast<std::size_t>(alignment);
  return countedMemory(std::aligned_alloc(line, (size + line - 1) / line * line), size);
}

void*
operator new[](std::size_t size)
{
  return operator new(size);
}

[[gnu::noinline]] void
operator delete(void* memory) noexcept
{
  auto& count = pcl_ext::io::test::memory_count;
  if (memory != nullptr && count.counts_bytes)
    count.live -= malloc_usable_size(memory);
  std::free(memory);
}

void
operator delete[](void* memory) noexcept
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
