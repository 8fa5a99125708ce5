// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "support/test_memory.h"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace pcl_ext::test {

namespace {

// Relaxed everywhere: allocations must not order the threads of a program, or the
// thread sanitizer would see fewer races than there are.
constexpr std::memory_order relaxed = std::memory_order_relaxed;

struct Counts {
  std::atomic<int> users{0};
  std::atomic<std::size_t> allocations{0};
  std::atomic<std::size_t> largest{0};
  std::atomic<std::ptrdiff_t> live{0};
  std::atomic<std::ptrdiff_t> peak{0};
};

Counts counts;

template <typename NumberT>
void
raise(std::atomic<NumberT>& maximum, NumberT number)
{
  NumberT before = maximum.load(relaxed);
  while (before < number && !maximum.compare_exchange_weak(before, number, relaxed)) {
  }
}

void
countTaken(void* memory, std::size_t size)
{
  if (counts.users.load(relaxed) == 0)
    return;
  counts.allocations.fetch_add(1, relaxed);
  raise(counts.largest, size);
  const auto usable = static_cast<std::ptrdiff_t>(malloc_usable_size(memory));
  raise(counts.peak, counts.live.fetch_add(usable, relaxed) + usable);
}

void
countGivenBack(void* memory)
{
  if (memory == nullptr || counts.users.load(relaxed) == 0)
    return;
  counts.live.fetch_sub(static_cast<std::ptrdiff_t>(malloc_usable_size(memory)),
                        relaxed);
}

struct Failing {
  std::atomic<std::size_t> number{0}; // 0: none
  std::atomic<bool> do_later_ones_fail{false};
  std::atomic<std::size_t> allocations{0}; // since one is to fail
};

Failing failing;
thread_local bool is_exempt = false;

/** \brief Whether the allocation that is asked for is one that fails. */
bool
isToFail()
{
  const std::size_t number = failing.number.load(relaxed);
  if (number == 0 || is_exempt)
    return false;
  const std::size_t own = failing.allocations.fetch_add(1, relaxed) + 1;
  return own == number || (own > number && failing.do_later_ones_fail.load(relaxed));
}

void*
takeMemory(std::size_t size, std::size_t alignment)
{
  if (isToFail())
    throw std::bad_alloc();
  void* const memory =
      alignment <= alignof(std::max_align_t)
          ? std::malloc(size)
          : std::aligned_alloc(alignment,
                               (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr)
    throw std::bad_alloc();
  countTaken(memory, size);
  return memory;
}

void*
takeMemoryOrNull(std::size_t size, std::size_t alignment) noexcept
{
  try {
    return takeMemory(size, alignment);
  }
  catch (const std::bad_alloc&) {
    return nullptr;
  }
}

void
giveBackMemory(void* memory) noexcept
{
  countGivenBack(memory);
  std::free(memory);
}

constexpr std::size_t usual_alignment = alignof(std::max_align_t);

} // namespace

MemoryUse::MemoryUse() : before_(counts.live.load(relaxed))
{
  counts.allocations.store(0, relaxed);
  counts.largest.store(0, relaxed);
  counts.peak.store(before_, relaxed);
  counts.users.fetch_add(1, relaxed);
}

MemoryUse::~MemoryUse() { counts.users.fetch_sub(1, relaxed); }

std::size_t
MemoryUse::allocations() const
{
  return counts.allocations.load(relaxed);
}

std::size_t
MemoryUse::largest() const
{
  return counts.largest.load(relaxed);
}

std::size_t
MemoryUse::live() const
{
  return static_cast<std::size_t>(
      std::max<std::ptrdiff_t>(0, counts.live.load(relaxed) - before_));
}

std::size_t
MemoryUse::peak() const
{
  return static_cast<std::size_t>(counts.peak.load(relaxed) - before_);
}

FailingAllocation::FailingAllocation(std::size_t number, bool do_later_ones_fail)
{
  failing.allocations.store(0, relaxed);
  failing.do_later_ones_fail.store(do_later_ones_fail, relaxed);
  failing.number.store(number, relaxed);
}

FailingAllocation::~FailingAllocation() { failing.number.store(0, relaxed); }

bool
FailingAllocation::hasFailed() const
{
  return failing.allocations.load(relaxed) >= failing.number.load(relaxed);
}

Exemption::Exemption() : was_exempt_(is_exempt) { is_exempt = true; }

Exemption::~Exemption() { is_exempt = was_exempt_; }

} // namespace pcl_ext::test

// All forms are replaced: what a sanitizer's own would give is not for free().
using pcl_ext::test::giveBackMemory;
using pcl_ext::test::takeMemory;
using pcl_ext::test::takeMemoryOrNull;
using pcl_ext::test::usual_alignment;

void*
operator new(std::size_t size)
{
  return takeMemory(size, usual_alignment);
}

void*
operator new[](std::size_t size)
{
  return takeMemory(size, usual_alignment);
}

void*
operator new(std::size_t size, std::align_val_t alignment)
{
  return takeMemory(size, static_cast<std::size_t>(alignment));
}

void*
operator new[](std::size_t size, std::align_val_t alignment)
{
  return takeMemory(size, static_cast<std::size_t>(alignment));
}

void*
operator new(std::size_t size, const std::nothrow_t& /*unused*/) noexcept
{
  return takeMemoryOrNull(size, usual_alignment);
}

void*
operator new[](std::size_t size, const std::nothrow_t& /*unused*/) noexcept
{
  return takeMemoryOrNull(size, usual_alignment);
}

void*
operator new(std::size_t size,
             std::align_val_t alignment,
             const std::nothrow_t& /*unused*/) noexcept
{
  return takeMemoryOrNull(size, static_cast<std::size_t>(alignment));
}

void*
operator new[](std::size_t size,
               std::align_val_t alignment,
               const std::nothrow_t& /*unused*/) noexcept
{
  return takeMemoryOrNull(size, static_cast<std::size_t>(alignment));
}

void
operator delete(void* memory) noexcept
{
  giveBackMemory(memory);
}

void
operator delete[](void* memory) noexcept
{
  giveBackMemory(memory);
}

void
operator delete(void* memory, std::size_t /*size*/) noexcept
{
  giveBackMemory(memory);
}

void
operator delete[](void* memory, std::size_t /*size*/) noexcept
{
  giveBackMemory(memory);
}

void
operator delete(void* memory, std::align_val_t /*alignment*/) noexcept
{
  giveBackMemory(memory);
}

void
operator delete[](void* memory, std::align_val_t /*alignment*/) noexcept
{
  giveBackMemory(memory);
}

void
operator delete(void* memory,
                std::size_t /*size*/,
                std::align_val_t /*alignment*/) noexcept
{
  giveBackMemory(memory);
}

void
operator delete[](void* memory,
                  std::size_t /*size*/,
                  std::align_val_t /*alignment*/) noexcept
{
  giveBackMemory(memory);
}

void
operator delete(void* memory, const std::nothrow_t& /*unused*/) noexcept
{
  giveBackMemory(memory);
}

void
operator delete[](void* memory, const std::nothrow_t& /*unused*/) noexcept
{
  giveBackMemory(memory);
}
