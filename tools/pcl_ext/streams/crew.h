// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace pcl_ext::tools {

/** \brief Tasks that several threads do, in the order in which they were added. Threads
 * that wait for something do tasks meanwhile, so that no more of them work than there
 * are. */
class Crew {
public:
  /** \param[in] size number of threads that will work, with those that add tasks */
  explicit Crew(unsigned int size) : size_(size) {}

  unsigned int
  size() const
  {
    return size_;
  }

  /** \brief Adds a task, which must not throw. */
  void
  add(std::function<void()> task);

  /** \brief Does tasks until a condition holds, which a task or wake() makes true. It is
   * called by one thread at a time. */
  void
  workUntil(const std::function<bool()>& isReached);

  /** \brief Lets waiting threads look at their conditions again.
   * \param[in] change what is done to them meanwhile
   */
  void
  wake(const std::function<void()>& change);

private:
  unsigned int size_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> tasks_;
};

/** \brief Runs a function in several threads at once, this one among them, and waits for
 * all of them.
 * \param[in] count number of threads; fewer if the system has no more
 * \param[in] work must not throw
 */
void
runInThreads(unsigned int count, const std::function<void()>& work);

/** \brief Threads that do the tasks of a crew, one fewer than its size, as long as this
 * exists. */
class CrewThreads {
public:
  explicit CrewThreads(Crew& crew);
  ~CrewThreads();
  CrewThreads(const CrewThreads&) = delete;
  CrewThreads&
  operator=(const CrewThreads&) = delete;

private:
  Crew& crew_;
  bool is_over_ = false;
  std::vector<std::thread> threads_;
};

} // namespace pcl_ext::tools
