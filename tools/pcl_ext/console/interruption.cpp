// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "console/interruption.h"

#include <chrono>
#include <csignal>
#include <initializer_list>

namespace pcl_ext::tools {

namespace {

#ifdef _WIN32
constexpr int processor_time_is_over = -1; // there is no such signal
#else
constexpr int processor_time_is_over = SIGXCPU; // a soft limit
#endif

volatile std::sig_atomic_t is_interrupted = 0;
volatile std::sig_atomic_t first_second = 0; // when the first signal came

/** \brief Seconds of a clock that never goes back. */
std::sig_atomic_t
secondNow()
{
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return static_cast<std::sig_atomic_t>(
      std::chrono::duration_cast<std::chrono::seconds>(now).count());
}

void
noteInterruption(int signal)
{
#ifdef _WIN32
  std::signal(signal, noteInterruption); // each signal takes its function away
#endif
  constexpr std::sig_atomic_t patience_s = 2;
  if (is_interrupted == 0) {
    first_second = secondNow();
    is_interrupted = 1;
  }
  // The command timeout sends its signal twice at once, and the kernel SIGXCPU each
  // second.
  else if (signal != processor_time_is_over &&
           secondNow() - first_second >= patience_s) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

} // namespace

void
catchInterruptions()
{
#ifdef _WIN32
  for (const int signal : {SIGINT, SIGTERM, SIGBREAK})
    std::signal(signal, noteInterruption);
#else
  struct sigaction action {};
  action.sa_handler = noteInterruption;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM, processor_time_is_over})
    sigaction(signal, &action, nullptr);
  // After nohup it stays ignored.
  struct sigaction hangup {};
  if (sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN)
    sigaction(SIGHUP, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN); // a limit on file sizes, which writing then reports
#endif
}

bool
isInterrupted()
{
  return is_interrupted != 0;
}

} // namespace pcl_ext::tools
