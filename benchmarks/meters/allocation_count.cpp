// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "meters/allocation_count.h"

#include <cstdlib>
#include <new>

namespace {

thread_local std::size_t allocations = 0;

void*
counted(void* memory)
{
  if (memory == nullptr)
    throw std::bad_alloc();
  ++allocations;
  return memory;
}

} // namespace

std::size_t
pcl_ext::measuring::allocationCount()
{
  return allocations;
}

// The operators of arrays call these. Not inline, as GCC would warn of malloc with
// delete and of new with free.
[[gnu::noinline]] void*
operator new(std::size_t size)
{
  return counted(std::malloc(size));
}

[[gnu::noinline]] void*
operator new(std::size_t size, std::align_val_t alignment)
{
  const auto line = static_cast<std::size_t>(alignment);
  return counted(std::aligned_alloc(line, (size + line - 1) / line * line));
}

[[gnu::noinline]] void
operator delete(void* memory) noexcept
{
  std::free(memory);
}

[[gnu::noinline]] void
operator delete(void* memory, std::align_val_t /*alignment*/) noexcept
{
  std::free(memory);
}

void
operator delete(void* memory, std::size_t /*size*/) noexcept
{
  operator delete(memory);
}

void
operator delete(void* memory, std::size_t /*size*/, std::align_val_t alignment) noexcept
{
  operator delete(memory, alignment);
}
