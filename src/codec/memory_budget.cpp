// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "bytes/machine_memory.h"
#include "codec/memory_share.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <list>
#include <utility>
#if !defined(__wasm__)
#include <mutex>
#endif

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

#if defined(__wasm__)
/** \brief There is one thread. */
struct Mutex {
  void
  lock()
  {}
  void
  unlock()
  {}
};
template <class MutexT>
struct Lock {
  explicit Lock(MutexT&) {}
};
#else
using Mutex = std::mutex;
template <class MutexT>
using Lock = std::lock_guard<MutexT>;
#endif

} // namespace

struct MemoryShare::Entry {
  std::function<void()> drop;
  std::size_t bytes = 0;
  std::list<Entry*>::iterator place; ///< in one of the lists
};

class MemoryBudget::Implementation {
public:
  using Entry = MemoryShare::Entry;

  explicit Implementation(std::size_t bytes) : limit_(bytes) {}

  void
  add(Entry& entry)
  {
    const Lock<Mutex> lock(mutex_);
    entry.place = idle_.insert(idle_.end(), &entry);
  }

  void
  remove(Entry& entry)
  {
    const Lock<Mutex> lock(mutex_);
    used_ -= entry.bytes;
    idle_.erase(entry.place);
  }

  void
  begin(Entry& entry)
  {
    const Lock<Mutex> lock(mutex_);
    busy_.splice(busy_.end(), idle_, entry.place);
  }

  void
  end(Entry& entry, std::size_t bytes)
  {
    const Lock<Mutex> lock(mutex_);
    used_ += bytes - entry.bytes;
    entry.bytes = bytes;
    idle_.splice(idle_.end(), busy_, entry.place);
    for (Entry* const oldest : idle_) {
      if (used_ <= limit_)
        break;
      if (oldest->bytes == 0)
        continue;
      oldest->drop();
      used_ -= std::exchange(oldest->bytes, 0);
      ++drops_;
    }
  }

  std::size_t
  limit() const
  {
    return limit_;
  }

  std::size_t
  used() const
  {
    const Lock<Mutex> lock(mutex_);
    return used_;
  }

  std::size_t
  drops() const
  {
    const Lock<Mutex> lock(mutex_);
    return drops_;
  }

private:
  const std::size_t limit_;
  mutable Mutex mutex_;
  // Each share is in one of them.
  std::list<Entry*> idle_; // that was used the longest ago first
  std::list<Entry*> busy_;
  std::size_t used_ = 0;
  std::size_t drops_ = 0;
};

MemoryBudget::MemoryBudget(std::size_t bytes)
: implementation_(
      std::make_unique<Implementation>(bytes == 0 ? machineBytes() / 4 : bytes))
{}

MemoryBudget::~MemoryBudget() = default;

std::size_t
MemoryBudget::limit() const
{
  return implementation_->limit();
}

std::size_t
MemoryBudget::used() const
{
  return implementation_->used();
}

std::size_t
MemoryBudget::drops() const
{
  return implementation_->drops();
}

std::size_t
MemoryBudget::machineBytes()
{
  return static_cast<std::size_t>(std::min<std::uint64_t>(
      machineMemory(), std::numeric_limits<std::size_t>::max()));
}

MemoryShare::MemoryShare(std::shared_ptr<MemoryBudget> budget,
                         std::function<void()> drop)
: budget_(std::move(budget))
{
  if (!budget_)
    return;
  entry_ = std::make_unique<Entry>();
  entry_->drop = std::move(drop);
  budget_->implementation_->add(*entry_);
}

MemoryShare::~MemoryShare()
{
  if (budget_)
    budget_->implementation_->remove(*entry_);
}

void
MemoryShare::begin() noexcept
{
  if (budget_)
    budget_->implementation_->begin(*entry_);
}

void
MemoryShare::end(std::size_t bytes) noexcept
{
  if (budget_)
    budget_->implementation_->end(*entry_, bytes);
}

} // namespace pcl_ext::PCL_EXT_ABI::io
