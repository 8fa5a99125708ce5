#include "interruption.h"

#include <csignal>

namespace pcl_ext {
namespace tools {

namespace {

volatile std::sig_atomic_t is_interrupted = 0;

void
noteInterruption(int /* signal */)
{
  is_interrupted = 1;
}

} // namespace

void
catchInterruptions()
{
  struct sigaction action {};
  action.sa_handler = noteInterruption;
  sigemptyset(&action.sa_mask);
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN); // a limit on file sizes, which writing then reports
}

bool
isInterrupted()
{
  return is_interrupted != 0;
}

} // namespace tools
} // namespace pcl_ext
