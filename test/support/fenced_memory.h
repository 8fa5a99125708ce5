/** \file
 * \brief Memory from operator new that ends, while wanted, where the next byte cannot be
 * read: a read behind a vector ends the program, without a sanitizer, too.
 *
 * \warning Exactly one translation unit per program may include this header: it
 * replaces the global operators.
 */
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace pcl_ext {
namespace io {
namespace test {

/** \brief Allocations at the end of pages of their own; programs of one thread only. */
class FencedMemory {
public:
  bool is_wanted = false;

  /** \brief Memory, or null if it is not wanted or there is no room in the table. */
  void*
  take(std::size_t size, std::size_t alignment)
  {
    Block* const block =
        std::find_if(blocks_.begin(), blocks_.end(), [](const Block& b) {
          return b.begin == nullptr;
        });
    if (!is_wanted || block == blocks_.end())
      return nullptr;
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    const std::size_t used = (size + alignment - 1) / alignment * alignment;
    const std::size_t before = (used + page - 1) / page * page;
    void* const pages = mmap(nullptr,
                             before + page,
                             PROT_READ | PROT_WRITE,
                             MAP_PRIVATE | MAP_ANONYMOUS,
                             -1,
                             0);
    if (pages == MAP_FAILED)
      return nullptr;
    char* const end = static_cast<char*>(pages) + before;
    if (mprotect(end, page, PROT_NONE) != 0)
      std::abort();
    *block = {end - used, pages, before + page};
    return block->begin;
  }

  /** \brief Gives memory back. \return false if it is none of these */
  bool
  giveBack(void* memory)
  {
    Block* const block =
        std::find_if(blocks_.begin(), blocks_.end(), [memory](const Block& b) {
          return b.begin == memory;
        });
    if (memory == nullptr || block == blocks_.end())
      return false;
    munmap(block->pages, block->size);
    *block = Block();
    return true;
  }

private:
  struct Block {
    void* begin = nullptr;
    void* pages = nullptr;
    std::size_t size = 0;
  };

  std::array<Block, 512> blocks_{};
};

inline FencedMemory fenced_memory;

} // namespace test
} // namespace io
} // namespace pcl_ext

// Not inline: GCC would see malloc and delete, or new and free, as a pair.
[[gnu::noinline]] void*
operator new(std::size_t size, std::align_val_t alignment)
{
  const auto line = static_cast<std::size_t>(alignment);
  if (void* const memory = pcl_ext::io::test::fenced_memory.take(size, line))
    return memory;
  if (void* const memory = std::aligned_alloc(line, (size + line - 1) / line * line))
    return memory;
  throw std::bad_alloc();
}

[[gnu::noinline]] void*
operator new(std::size_t size)
{
  return operator new (size, std::align_val_t{alignof(std::max_align_t)});
}

void*
operator new[](std::size_t size)
{
  return operator new(size);
}

[[gnu::noinline]] void
operator delete(void* memory) noexcept
{
  if (!pcl_ext::io::test::fenced_memory.giveBack(memory))
    std::free(memory);
}

void
operator delete[](void* memory) noexcept
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
