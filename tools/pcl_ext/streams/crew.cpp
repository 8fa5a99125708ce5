// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "streams/crew.h"

#include <system_error>
#include <utility>

namespace pcl_ext::tools {

namespace {

/** \brief Starts so many threads, or as many of them as the system has room for. */
void
start(unsigned int count,
      const std::function<void()>& work,
      std::vector<std::thread>& threads)
{
  threads.reserve(count);
  try {
    while (threads.size() < count)
      threads.emplace_back(work);
  }
  catch (const std::system_error&) {
    // Fewer do the same.
  }
}

} // namespace

void
Crew::add(std::function<void()> task)
{
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    tasks_.push_back(std::move(task));
  }
  changed_.notify_one();
}

void
Crew::workUntil(const std::function<bool()>& isReached)
{
  std::unique_lock<std::mutex> lock(mutex_);
  while (!isReached()) {
    if (tasks_.empty()) {
      changed_.wait(lock);
      continue;
    }
    {
      const std::function<void()> task = std::move(tasks_.front());
      tasks_.pop_front();
      lock.unlock();
      task();
    }
    lock.lock();
    changed_.notify_all();
  }
  // The one that add() woke may leave; another one does the task.
  if (!tasks_.empty())
    changed_.notify_one();
}

void
Crew::wake(const std::function<void()>& change)
{
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    change();
  }
  changed_.notify_all();
}

void
runInThreads(unsigned int count, const std::function<void()>& work)
{
  std::vector<std::thread> threads;
  start(count - 1, work, threads);
  work();
  for (std::thread& thread : threads)
    thread.join();
}

CrewThreads::CrewThreads(Crew& crew) : crew_(crew)
{
  start(
      crew.size() - 1,
      [this] { crew_.workUntil([this] { return is_over_; }); },
      threads_);
}

CrewThreads::~CrewThreads()
{
  crew_.wake([this] { is_over_ = true; });
  for (std::thread& thread : threads_)
    thread.join();
}

} // namespace pcl_ext::tools
