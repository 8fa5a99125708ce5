// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "console/terminal.h"

#ifdef _WIN32
#include <windows.h>
#else
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>
#endif

namespace pcl_ext::tools {

#ifdef _WIN32

namespace {

HANDLE
handleOf(StandardStream stream)
{
  return ::GetStdHandle(stream == StandardStream::Input    ? STD_INPUT_HANDLE
                        : stream == StandardStream::Output ? STD_OUTPUT_HANDLE
                                                           : STD_ERROR_HANDLE);
}

} // namespace

bool
isTerminal(StandardStream stream)
{
  DWORD mode = 0;
  if (::GetConsoleMode(handleOf(stream), &mode) == 0)
    return false;
  constexpr DWORD escape_sequences = 0x0004; // not in all headers
  return stream == StandardStream::Input ||
         ::SetConsoleMode(handleOf(stream), mode | escape_sequences) != 0;
}

std::size_t
terminalWidth()
{
  CONSOLE_SCREEN_BUFFER_INFO screen{};
  return ::GetConsoleScreenBufferInfo(handleOf(StandardStream::Error), &screen) != 0
             ? static_cast<std::size_t>(screen.srWindow.Right - screen.srWindow.Left) +
                   1
             : 0;
}

bool
isReaderGone()
{
  return false;
}

#else

bool
isTerminal(StandardStream stream)
{
  return ::isatty(static_cast<int>(stream)) != 0;
}

std::size_t
terminalWidth()
{
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

bool
isReaderGone()
{
  pollfd output{STDOUT_FILENO, POLLOUT, 0};
  return ::poll(&output, 1, 0) == 1 && (output.revents & POLLERR) != 0;
}

#endif

} // namespace pcl_ext::tools
